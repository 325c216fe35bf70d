"""Every drive at every extreme: the error against the truth, the counted work, and that nothing but a correct value or a
clear error comes out. The cases are in the folder `extremes`, the table of what they found in its README.md."""

import pytest

from extremes import backlash, elastic_output, elastic_shaft, parametric, rigid_machine, suite  # noqa: F401, they declare cases


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return suite.Packages(tmp_path_factory.mktemp("extremes"))


OUTCOMES = {}


@pytest.mark.parametrize("case", suite.CASES, ids=lambda c: c.name)
def test_extreme(packages, case):
    outcome = case.run(packages)
    suite.check(case, outcome)
    OUTCOMES[case.name] = outcome


def test_the_table_holds():
    """The committed statements are true, and each case has its row."""
    if len(OUTCOMES) < len(suite.CASES):
        pytest.skip("not all cases ran")
    outcomes = [(case, OUTCOMES[case.name]) for case in suite.CASES]
    if suite.BLESS:
        suite.README.write_text(suite.table(outcomes))
    rows = suite.committed()
    names = [(c.drive, c.extreme) for c in suite.CASES]
    assert len(set(names)) == len(names) and set(rows) == set(names)
    for case, outcome in outcomes:
        found, bound, truth, *work = rows[case.drive, case.extreme]
        assert truth == case.truth, case.name
        if case.message is not None:
            assert found == f"refused: “{case.message}”", case.name
            continue
        assert bound == suite.number(case.bound), case.name
        assert outcome.error <= float(found), f"{case.name}: error {outcome.error:.2e}, stated {found}"
        for counted, stated in zip((outcome.steps, outcome.evaluations), work):
            assert counted <= float(stated), f"{case.name}: work {counted}, stated {stated}"
