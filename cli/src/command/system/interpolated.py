def step(parts, time, h):
    """Machines step first with extrapolated torques, then the drives with the machines' motion at both ends of the step."""
    motion = lambda name: [parts[name].get(output) for output in ("phi", "w", "a")]
    first = [name for name in parts if name not in SHAFTS]
    for name in first:
        connect(parts, name, h)
    # With the torques of this step; with the torques of the previous one the exchange is less stable.
    begin = {machine: motion(machine) for machine, _, _ in SHAFTS.values()}
    for name in first:
        parts[name].fmu.doStep(time, h)
    for name, (machine, ratio, offset) in SHAFTS.items():
        connect(parts, name)
        (phi, w, a), end = begin[machine], motion(machine)
        if not parts[name].follows:
            # An FMU may refuse higher derivatives, so the inputs are linear.
            for variable, value, last in zip(("phi", "w", "a"), (ratio * phi + offset, ratio * w, ratio * a), end):
                parts[name].set(variable, value, (ratio * last + offset * (variable == "phi") - value) / h)
            parts[name].fmu.doStep(time, h)
            continue
        # phi + w h + a h²/2 + a1 h³/6 + a2 h⁴/24 and its derivative match the end of the step.
        place, speed = end[0] - phi - w * h - a * h * h / 2, (end[1] - w - a * h) * h
        a1, a2 = (24 * place - 6 * speed) / h**3, (24 * speed - 72 * place) / h**4
        parts[name].set("phi", ratio * phi + offset)
        parts[name].set("w", ratio * w)
        parts[name].set("a", ratio * a, ratio * a1, ratio * a2)
        parts[name].fmu.doStep(time, h)

