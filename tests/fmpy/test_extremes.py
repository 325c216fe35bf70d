"""Every drive at every extreme: the error against the truth, the counted work, and that nothing but a correct value or a
clear error comes out. The cases are in the folder `extremes`, the table of what they found in its README.md."""

import pytest

from extremes import backlash, elastic_output, elastic_shaft, parametric, rigid_machine, suite, train  # noqa: F401, they declare cases


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return suite.Packages(tmp_path_factory.mktemp("extremes"))


OUTCOMES = {}


@pytest.mark.parametrize("case", suite.CASES, ids=lambda c: c.name)
def test_extreme(packages, case):
    outcome = case.run(packages)
    suite.check(case, outcome)
    OUTCOMES[case.name] = outcome
    if not suite.BLESS:
        compare(case, outcome, *suite.committed()[case.drive, case.extreme])


def compare(case, outcome, found, bound, truth, *work):
    """The committed statements are true."""
    assert truth == case.truth
    if case.message is not None:
        assert found == f"refused: “{case.message}”"
        return
    assert bound == suite.number(case.bound)
    assert outcome.error <= float(found), f"error {outcome.error:.2e}, stated {found}"
    for counted, stated in zip((outcome.steps, outcome.evaluations), work):
        assert counted <= float(stated), f"work {counted}, stated {stated}"


def test_each_case_has_its_row():
    if suite.BLESS:
        suite.README.write_text(suite.table([(case, OUTCOMES[case.name]) for case in suite.CASES]))
    names = [(c.drive, c.extreme) for c in suite.CASES]
    assert len(set(names)) == len(names) and set(suite.committed()) == set(names)
