"""``ukrt devices``: the audio outputs, JACK ports and MIDI inputs of this machine, with the names to choose them by."""

from ..errors import DeviceError, MissingExtraError
from .common import add_command, make_console

_EPILOG = """\
The default is marked with *. Choose with
  ukrt play --audio-out NAME|INDEX --host-api NAME --midi-in NAME
  ukrt play --driver jack --audio-out NAME --midi-in NAME
where NAME may be a part of the name.
"""


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "devices", "list the audio outputs and MIDI inputs of this machine", _EPILOG)
    parser.set_defaults(run=run)


def run(args):
    """Print the lists; a machine without any of it is told so, which is no failure."""
    print_devices()
    return 0


def print_devices():
    """All tables to standard output."""
    from rich.console import Console

    from ukrt.drivers.midi import inputs as midi_in

    console = Console(highlight=False, soft_wrap=True)
    outputs = _outputs()
    if outputs:
        console.print(_audio_table(outputs))
    else:
        console.print("audio outputs: none found (ukrt play then writes what would be heard to a WAV file)")
    server = _jack_server()
    if server is not None:
        _print_server(console, server)
    inputs, chosen = midi_in.list_inputs(), midi_in.find_input()
    if inputs:
        console.print(_midi_table(inputs, chosen))
    else:
        console.print("MIDI inputs: none found (ukrt play then plays the bundled piece)")


def _outputs():
    from ukrt.drivers.sound import process as audio_process

    try:
        return audio_process.list_outputs()
    except DeviceError as error:
        make_console().print(f"ukrt: {error}", markup=False)
        return []


def _jack_server():
    """The JACK server that answers, None without one or without JACK-Client."""
    from ..drivers.jack.server import find_server

    try:
        return find_server()
    except (DeviceError, MissingExtraError):
        return None


def _table(title, *columns):
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE, title_style="bold")
    for name in columns:
        table.add_column(name, justify="left" if name in ("", "name", "host API", "API", "port", "is") else "right")
    return table


def _audio_table(outputs):
    from rich.markup import escape

    table = _table("audio outputs", "", "index", "name", "host API", "channels", "rate/Hz")
    for o in outputs:
        mark = "*" if o.is_default else ""
        table.add_row(mark, str(o.index), escape(o.name), o.host_api, str(o.channels), f"{o.sample_rate:.0f}")
    return table


def _print_server(console, server):
    """A JACK server and the ports that ``--driver jack`` could be connected to."""
    from rich.markup import escape

    kind = "real time" if server.realtime else "not real time"
    title = f"JACK server {server.name}: {server.sample_rate:.0f} Hz, {server.block_size} frames, {kind}"
    table = _table(escape(title), "port", "is")
    for name in server.outputs:
        table.add_row(escape(name), "audio output")
    for name in server.midi_sources:
        table.add_row(escape(name), "MIDI device")
    console.print(table)


def _midi_table(inputs, chosen):
    from rich.markup import escape

    table = _table("MIDI inputs", "", "index", "name", "API")
    for port in inputs:
        table.add_row("*" if port == chosen else "", str(port.index), escape(port.name), port.api)
    return table
