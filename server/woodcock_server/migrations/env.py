"""Run by Alembic, on the connection that woodcock_server.database hands over."""

from alembic import context

from woodcock_server.tables import metadata

context.configure(connection=context.config.attributes["connection"], target_metadata=metadata)
context.run_migrations()
