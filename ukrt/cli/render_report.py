"""What ``ukrt render`` made of a file, in words: a report enters, lines leave."""

from .common import clock_time, describe_notes


def _describe_fingering(chosen):
    """How strings and positions were chosen, in words."""
    words = [chosen["choice"] + (f": {chosen['why']}" if chosen["why"] else "")]
    if chosen["let_go"]:
        words.append(f"{chosen['let_go']} notes end early for the hand's sake")
    return ", ".join(words)


def summary(target, report):
    """The summary, in words."""
    peak, speed = report["peak_dbfs"], report["times_real_time"]
    start = f" from {clock_time(report['start_s'])} on" if report["start_s"] > 0.0 else ""
    lines = [
        f"{target}: {clock_time(report['duration_s'])}{start}, {report['sample_rate']:.0f} Hz, "
        f"{report['channels']} channel{'s' if report['channels'] > 1 else ''}, {report['bits']} bit",
        f"  notes           {describe_notes(report | {'notes_on': report['notes_total']})}",
        f"  peak            {'silence' if peak is None else f'{peak:.1f} dBFS'}",
    ]
    if chosen := report.get("fingering"):
        lines.append(f"  fingering       {_describe_fingering(chosen)}")
    if speed is not None:
        lines.append(f"  times real time {speed:.1f}")
    if len(report.get("files", ())) > 1:
        lines.append(f"  goes on in      {', '.join(report['files'][1:])}, at other sample rates")
    if "recorded_with" in report and report["bits"] == "32f" and not report["warnings"]:
        lines.append("  take            bit for bit as it was played")
    if report["clipped_samples"]:
        lines.append(
            f"  clipped         {report['clipped_samples']} samples beyond full scale; lower --gain, or --bits 32f"
        )
    return "\n".join(lines)
