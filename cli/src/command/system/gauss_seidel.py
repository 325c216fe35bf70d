def step(parts, time, h):
    """Drives first, with the motion at the beginning of the step; then machines, with the torques at its end."""
    for name in sorted(parts, key=lambda name: name not in SHAFTS):
        connect(parts, name)
        parts[name].fmu.doStep(time, h)

