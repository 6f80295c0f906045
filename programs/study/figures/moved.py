"""Of a result of experiments/moved.py: what its heads are called, and a system's entries by head."""


def head_text(head):
    """"as told", "20 degrees", "5 cm" or both of these."""
    said = [*([f"{head['turned_deg']:g} degrees"] if head["turned_deg"] else []), *([f"{100 * head['moved_m']:g} cm"] if head["moved_m"] else [])]
    return ", ".join(said) or "as told"


def by_head(result, system):
    """{head: entry}, of the heads in their order; empty where the scene has no such system."""
    found = {entry["head"]: entry for entry in result["systems"] if entry["system"] == system}
    return {head["name"]: found[head["name"]] for head in result["heads"] if head["name"] in found}
