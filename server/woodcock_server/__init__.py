"""The service: jobs in over HTTP, rendered on every OpenCL device there is."""
