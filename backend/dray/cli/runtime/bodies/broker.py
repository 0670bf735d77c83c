"""The broker of bodies."""

from __future__ import annotations

from dray.adapters.vda5050.link import BrokerAddress, read_address
from dray.errors import SettingsError
from dray.settings import Settings


def broker_of(settings: Settings) -> BrokerAddress:
    """The broker in the settings.

    Raises:
        SettingsError: there is none.
    """
    if not settings.broker:
        raise SettingsError("DRAY_BROKER", "a real body is behind a broker: say where that is")
    host, port, tls = read_address(settings.broker)
    password = settings.broker_password
    return BrokerAddress(
        host,
        port,
        tls,
        user=settings.broker_user,
        password="" if password is None else password.get_secret_value(),
        authority=settings.broker_authority,
        certificate=settings.broker_certificate,
        key=settings.broker_key,
    )
