"""Public holidays of countries and their regions, by the library `holidays`.

The library takes a second to import, and 45 MB of memory: it is imported when a calendar names a region.
"""

from __future__ import annotations

import asyncio
import warnings
from datetime import date
from functools import cache, lru_cache

from dray.gateway.http.problems import FieldError

YEARS_MAX = 1024
"""Maximum years of regions that are remembered, about 2 KB each."""


async def load() -> None:
    """Import the library in a thread, unless it is there: requests go on meanwhile."""
    if not _countries.cache_info().currsize:
        await asyncio.to_thread(_countries)


def fault_of(region: str) -> FieldError | None:
    """Why a region has no holidays here; None if it has.

    Args:
        region: a country, as `DE`, or a country and its region, as `DE-BW` (ISO 3166).
    """
    country, dash, part = region.partition("-")
    regions = _countries().get(country)
    if regions is None:
        return FieldError.of("holidays_of", "country_unknown", country=country)
    if not dash or part in regions:
        return None
    if not regions:
        return FieldError.of("holidays_of", "region_none", country=country)
    return FieldError.of(
        "holidays_of", "region_unknown", country=country, region=part, regions=_named(country)
    )


@lru_cache(maxsize=YEARS_MAX)
def of_year(region: str, year: int) -> frozenset[date]:
    """The public holidays of a region that `fault_of` accepts, in one year."""
    import holidays  # noqa: PLC0415 (see above)

    country, _, part = region.partition("-")
    with warnings.catch_warnings():
        # The library warns where it does not know the holidays of a year yet.
        warnings.simplefilter("ignore")
        return frozenset(holidays.country_holidays(country, subdiv=part or None, years=year))


@cache
def _countries() -> dict[str, list[str]]:
    import holidays  # noqa: PLC0415 (see above)

    return holidays.list_supported_countries(include_aliases=False)


def _named(country: str) -> str:
    """The regions of a country with their names, as far as they have some."""
    import holidays  # noqa: PLC0415 (see above)

    names = holidays.country_holidays(country).get_subdivision_aliases()
    return ", ".join(f"{part} ({given[0]})" if given else part for part, given in names.items())
