"""Identity: the files with a process's own certificate and its trusted authorities."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dray.errors import SettingsError


@dataclass(frozen=True, slots=True)
class Identity:
    """A process's own certificate and its trusted authorities, as PEM files.

    Attributes:
        authority: certificates of the trusted authorities.
        certificate: our own, signed by such an authority.
        key: the private key of our certificate.
    """

    authority: Path
    certificate: Path
    key: Path

    @classmethod
    def in_folder(cls, folder: Path, name: str) -> Identity:
        """The files as `dray certs` writes them.

        Raises:
            SettingsError: one of them is missing.
        """
        found = cls(folder / "authority.pem", folder / f"{name}.pem", folder / f"{name}.key")
        for file in (found.authority, found.certificate, found.key):
            if not file.is_file():
                raise SettingsError(str(file), "there is no such file; `dray certs` makes certificates")
        return found
