"""What runs of `raybundle bench` left behind."""

import json


def load(file):
    return json.loads(file.read_text()) if file.is_file() else None


def fastest(folder):
    """Of the runs of one variant, which differ in time only: its log (None where there is none), its
    outcome and its comparison with the truth."""
    logs = [(load(file), file.stem) for file in sorted(folder.glob("*.json")) if file.stem.isdigit()]
    log, number = min(logs, key=lambda each: each[0]["summary"]["seconds"]["total"], default=(None, "1"))
    outcome = load(folder / f"{number}.run.json") or {"status": "not run", "message": ""}
    truth = (load(folder / f"{number}.eval.json") or {}).get("truth") or {}
    return log, outcome, truth


def machine(folder):
    for file in sorted(folder.glob("*/machine.json")):
        data = load(file)
        return f"{data.get('processor', '?')}, {data.get('cores', '?')} cores"
    return "unknown"
