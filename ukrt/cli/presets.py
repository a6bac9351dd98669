"""``ukrt presets``: the guitars there are; with a name, that guitar as TOML which ``--preset`` loads again."""

from .common import (
    UsageError,
    add_command,
    add_mode_options,
    add_set_option,
    add_tuning_options,
    given_settings,
    load_guitar,
    say,
)

_EPILOG = """\
examples:
  ukrt presets
  ukrt presets classical > mine.toml
  ukrt presets drop-d --set pluck.place=0.8
  ukrt presets classical --tuning open-g > open-g.toml
"""


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "presets", "list the guitars, or print one as TOML that can be loaded", _EPILOG)
    parser.add_argument("preset", nargs="?", metavar="NAME|FILE", help="print this one as TOML that can be loaded")
    parser.add_argument(
        "--banks", action="store_true", help="list them as bank and program, by which MIDI chooses them in `ukrt play`"
    )
    add_tuning_options(parser)
    add_mode_options(parser)
    add_set_option(parser, "change one value before printing")
    parser.set_defaults(run=run)


def run(args):
    """List or print."""
    from ..model.preset_text import dump_preset
    from ..model.presets import load_preset, preset_names
    from ..model.string_limits import tuning_warnings

    if args.preset is not None and args.banks:
        raise UsageError("--banks lists all presets; leave the name away")
    if args.preset is not None:
        guitar = load_guitar(args)
        for warning in tuning_warnings(guitar):
            say(f"tuning: {warning}")
        print(dump_preset(guitar), end="")
        return 0
    if given := given_settings(args.overrides):
        words = f"{given[0]} changes a preset that is printed; name it"
        raise UsageError(f"{words}, as in: ukrt presets classical {given[0]} ...")
    names = preset_names()
    if args.banks:
        print("bank 0 (CC 0 and 32 at 0)       program 0, 1, ...: what `ukrt play --preset` names, in that order")
        for program, name in enumerate(names):
            print(f"bank 1 (CC 0 or 32 at 1)        program {program}: {name}")
        return 0
    width = max(map(len, names), default=0)
    for name in names:
        print(f"{name:<{width}}  {load_preset(name).description}")
    return 0
