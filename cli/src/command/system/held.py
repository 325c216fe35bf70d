def step(parts, time, h):
    """All parts step with the values from the start of the step."""
    values = [factor * parts[source].get(output) + offset for source, output, _, _, factor, offset in CONNECTIONS]
    for (_, _, part, name, _, _), value in zip(CONNECTIONS, values):
        parts[part].set(name, value)
    for part in parts.values():
        part.fmu.doStep(time, h)

