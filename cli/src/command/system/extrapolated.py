def step(parts, time, h):
    """All parts step with the values of the beginning and their first derivatives."""
    told = [(factor * parts[source].get(output) + offset, factor * parts[source].rate(output, h))
            for source, output, _, _, factor, offset in CONNECTIONS]
    moved = {"phi", "w"}  # Whose course is that of a.
    for (_, _, part, name, _, _), (value, rate) in zip(CONNECTIONS, told):
        parts[part].set(name, value, *([] if part in SHAFTS and name in moved and parts[part].follows else [rate]))
    for part in parts.values():
        part.fmu.doStep(time, h)

