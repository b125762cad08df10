"""The certificate by which the processes of a service, or of a farm, know each other."""

from __future__ import annotations

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from distributed import Security

#: One that is made at every start is known to nobody else, so that its dates say nothing. Those of Dask's own are a
#: year from now: a worker that starts after a clock was set back, or in the second year, would be refused.
VALID = timedelta(days=36500)

#: The files of a farm's certificate, as Kubernetes names those of a TLS secret.
AUTHORITY, CERTIFICATE, KEY = "ca.crt", "tls.crt", "tls.key"


class CertificateError(ValueError):
    """A folder's files are no certificate to join a farm with."""


def security() -> Security:
    """For TLS among scheduler, workers and clients, in these processes' memory alone."""
    certificate, key = _make(VALID)
    return _mutual(certificate, certificate, key)


def write(folder: Path, valid: timedelta) -> None:
    """A new certificate, which vouches for itself, and its key. Raises OSError; FileExistsError where one is."""
    folder.mkdir(parents=True, exist_ok=True)
    certificate, key = _make(valid)
    for name, text, mode in ((KEY, key, 0o600), (CERTIFICATE, certificate, 0o644), (AUTHORITY, certificate, 0o644)):
        with os.fdopen(os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "w") as file:
            file.write(text)


def of(folder: Path | None) -> Security:
    """For TLS among the machines of a farm. Raises CertificateError."""
    if folder is None:
        raise CertificateError(
            "WOODCOCK_CERTIFICATES (or --certificates): the folder of the farm's certificate, which "
            "`woodcock certificates FOLDER` makes."
        )
    try:
        authority, certificate, key = ((folder / name).read_text() for name in (AUTHORITY, CERTIFICATE, KEY))
        secure = _mutual(authority, certificate, key)
        secure.get_connection_args("client")  # type: ignore[no-untyped-call]
    except FileNotFoundError as error:
        raise CertificateError(f"{error.filename} is missing; `woodcock certificates FOLDER` makes it.") from None
    except (OSError, ValueError) as error:
        raise CertificateError(f"The certificate in {folder} cannot be used: {error}") from None
    return secure


def _make(valid: timedelta) -> tuple[str, str]:
    """PEM of a certificate that vouches for itself, and of its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "woodcock")])
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("woodcock")]), critical=False)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - VALID / 2)
        .not_valid_after(now + valid)
        .sign(key, hashes.SHA256())
        .public_bytes(serialization.Encoding.PEM)
        .decode()
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    ).decode()
    return certificate, secret


def _mutual(authority: str, certificate: str, key: str) -> Security:
    """Each side shows the certificate, and asks for one that the authority vouches for."""
    roles = {f"tls_{role}_{what}": value for role in ("client", "scheduler", "worker") for what, value in
             (("key", key), ("cert", certificate))}  # fmt: skip
    return Security(require_encryption=True, tls_ca_file=authority, **roles)  # type: ignore[no-untyped-call]
