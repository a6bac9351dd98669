"""A JACK client with one MIDI output, driven through standard input: lines of JSON, each answered with one."""

import json
import sys
import time

import rtmidi


def main():
    out = rtmidi.MidiOut(rtmidi.API_UNIX_JACK, name=sys.argv[1])
    out.open_virtual_port("out")
    print("{}", flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        due, step = time.perf_counter(), request.get("step", 0.0)
        for message in request["messages"]:
            while time.perf_counter() < due:
                time.sleep(step / 4)
            out.send_message(message)
            due += step
        print("{}", flush=True)
    out.close_port()
    out.delete()


main()
