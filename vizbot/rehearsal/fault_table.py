"""`--faults list`: what can go wrong in a dry run."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from sim_stubs.faults.catalogue import CATALOGUE, Fault


def show() -> None:
    """Print the catalogue."""
    table = Table(box=None, pad_edge=False)
    table.add_column("fault", no_wrap=True)
    table.add_column("what happens -> what the robot must do")
    table.add_column("stops within", no_wrap=True)
    for fault in CATALOGUE.values():
        table.add_row(fault.name, f"{fault.what} -> {fault.must}", _stops_within(fault))
    Console().print(table)


def _stops_within(fault: Fault) -> str:
    if fault.stops_within is None:
        return "-"
    within = f"{fault.stops_within:g} s"
    return within if fault.reaches_wheels else f"cannot stop, {within} once back"
