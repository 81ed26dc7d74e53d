"""The commands `stones`, `setups`, `materials` and `doctor`: what is there, and whether it works."""

from __future__ import annotations

import itertools

import typer

from gemrender.cli.output import stdout

__all__ = ["doctor", "materials", "setups", "stones"]


def stones() -> None:
    """List the bundled stones."""
    from gemrender.stone import bundled_stones, load_stone

    for name in bundled_stones():
        typer.echo(f"{name:<16} {load_stone(name).name}")


def setups() -> None:
    """List the set-ups that stones can be pictured in."""
    from gemrender.scene.setup import bundled_setups, load_setup

    for name in bundled_setups():
        setup = load_setup(name)
        typer.echo(f"{name:<16} {setup.name}: {setup.about}")


def materials() -> None:
    """List the materials: index at 589.3 nm, dispersion (B to G), density, and where they come from."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    from gemrender.optics import load_material, material_names, refractive_index

    rows = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    rows.add_column("Material", no_wrap=True)
    for column in ("n", "B-G", "g/cm3"):
        rows.add_column(column, justify="right", no_wrap=True)
    rows.add_column("Source and notes")
    made = {}
    for name in material_names():
        material = load_material(name)
        numbers = (refractive_index(name), material.dispersion_b_g, material.density)
        made[name] = (*numbers, "; ".join(part for part in (material.source, material.note) if part))
    for (index, dispersion, density, words), group in itertools.groupby(made, key=lambda name: made[name]):
        names = list(group)  # the grades of diamond share a row
        called = names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
        rows.add_row(Text(called), f"{index:.4f}", f"{dispersion:.4f}", f"{density:.2f}", Text(words))
    stdout().print(rows)


def doctor() -> None:
    """Say what of Mitsuba, Dr.Jit and LLVM was found, and whether gemrender can run here."""
    from gemrender.render.diagnosis import diagnose
    from gemrender.report.doctor import print_doctor

    if not print_doctor(diagnose(), stdout()):
        raise typer.Exit(1)
