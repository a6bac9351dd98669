"""Proof 1: what a busy Python does to the callback. Blocks and stresses enter; loads, xruns and losses leave.

Compiled, empty and Python callbacks take turns on one server; the stress runs in the main thread of the very process
whose audio thread is measured.
"""

import json
import sys

import numpy as np

from .server import RATE, answer, child, jack_server

SOURCES = ("compiled", "empty", "python")


def run(options, say):
    """All cells, one after another (list of dict)."""
    cells = []
    for block in options.blocks:
        with jack_server(block) as environment:
            common = ["--driver", options.driver, "--slice-seconds", options.slice_seconds, "--turns", options.turns]
            stresses = ["--stresses", ",".join(options.stresses)]
            with child("cells-worker", "--blocks", block, *common, *stresses, environment=environment) as worker:
                for _ in options.stresses:
                    cell = answer(worker, f"{block} frames")
                    cell["realtime_server"] = environment["UKRT_PROOF_REALTIME"] == "yes"
                    cells.append(cell)
                    say(_line(cell))
    return cells


def work(options):
    """In a process of its own: measure one block size under each stress, a line of JSON for each."""
    from ukrt.drivers.doctor.measure import measure_turns, summarize, within_range
    from ukrt.drivers.doctor.outputs import find_outputs
    from ukrt.drivers.doctor.sources import Compiled, Empty, Interpreted
    from ukrt.engine.engine import Engine
    from ukrt.model.presets import load_preset

    guitar = load_preset("classical")
    outputs, _ = find_outputs(options.driver, RATE)
    engines = [Engine(guitar, float(RATE)), Engine(guitar, float(RATE))]
    sources = [Compiled(engines[0]), Empty(RATE, engines[0].channels), Interpreted(engines[1])]
    (block,) = options.blocks
    for stress in options.stresses:
        slices = measure_turns(
            sources, outputs.open, stress, block, options.slice_seconds, options.turns, lambda _: None
        )
        by_source = {name: [one for one in slices if one.source == name] for name in SOURCES}
        cell = {
            "block": block,
            "stress": stress,
            "driver": options.driver,
            "strings_plucked": sources[0].strings_plucked(),
            "sources": {name: summarize(own) for name, own in by_source.items()},
            "within_range": within_range(by_source["compiled"], by_source["empty"]),
            "slices": [one.to_dict() for one in slices],
        }
        print(json.dumps(cell), flush=True)
    sys.stdin.read()  # until the parent has seen it all


def verdict(cells):
    """Whether compiled slices lie within the range of empty ones, cell by cell and over all (dict)."""
    total = {name: {"missing": 0, "xruns": 0, "blocks": 0} for name in SOURCES}
    for cell in cells:
        for name in SOURCES:
            for kind in total[name]:
                total[name][kind] += cell["sources"][name][kind]
    outside = [
        f"{cell['block']} frames, {cell['stress']}: {kind}"
        for cell in cells
        for kind, within in cell["within_range"].items()
        if not within
    ]
    chances = {kind: chance_of(cells, kind) for kind in ("missing", "xruns")}
    return {
        "cells": len(cells),
        "outside_the_range_of_empty_slices": outside,
        "totals": total,
        "chance_that_nothing_is_as_bad": chances,
    }


def chance_of(cells, kind, shuffles=20_000):
    """How often compiled would come out as bad against empty as it did if both were the same (0 to 1).

    Each turn's compiled and empty slice are swapped at random; small values mean that the instrument makes a
    difference.
    """
    pairs = []
    for cell in cells:
        counts = {
            name: [max(one["xruns"], one["flags"]["underflows"]) if kind == "xruns" else one["missing"] for one in own]
            for name in ("compiled", "empty")
            for own in [[one for one in cell["slices"] if one["source"] == name]]
        }
        pairs += zip(counts["compiled"], counts["empty"], strict=True)
    differences = np.array([mine - nothing for mine, nothing in pairs])
    signs = np.random.default_rng(1).choice((-1, 1), (shuffles, len(differences)))
    return float((signs @ differences >= differences.sum()).mean())


def table(cells):
    """The cells for a terminal (rich table)."""
    from rich import box
    from rich.table import Table

    grid = Table(box=box.SIMPLE, title="xruns and load; ranges are over the slices", title_justify="left")
    for name in ("frames", "stress", "callback", "p50 %", "p99 %", "p99.9 %", "max %", "xruns", "missing", "of all"):
        grid.add_column(name, justify="left" if name in ("stress", "callback") else "right", no_wrap=True)
    for cell in cells:
        for name in SOURCES:
            result = cell["sources"][name]
            loads = result["load"]
            shares = [f"{100 * loads[q]:.0f}" if loads else "" for q in ("p50", "p99", "p99.9", "max")]
            counts = [f"{result[k]} ({'-'.join(map(str, result[k + '_range']))})" for k in ("xruns", "missing")]
            share = f"{result['missing_percent']:.3g} %"
            first = (str(cell["block"]), cell["stress"]) if name == SOURCES[0] else ("", "")
            grid.add_row(*first, name, *shares, *counts, share, end_section=name == SOURCES[-1])
    return grid


def _line(cell):
    words = [f"{name} {cell['sources'][name]['missing']}/{cell['sources'][name]['xruns']}" for name in SOURCES]
    return f"{cell['block']} frames, {cell['stress']}: missing/xruns {', '.join(words)}; within {cell['within_range']}"
