"""Arguments that no group can take are refused, and named: other objects, other shapes, numbers beyond doubles."""

from __future__ import annotations

import pytest

from lie_rigid_body import ParameterError
from lie_rigid_body.groups import SO, SU, product
from lie_rigid_body.groups.algebra import MOST_GENERATORS

pytestmark = pytest.mark.filterwarnings("error")


@pytest.mark.parametrize(
    ("family", "dimension"), [(SO, lambda n: n * (n - 1) // 2), (SU, lambda n: n * n - 1)], ids=["SO", "SU"]
)
def test_the_largest_group_is_the_last_whose_structure_constants_take_4_gib(family, dimension):
    fits = [n for n in range(2, 60) if dimension(n) ** 3 * 8 <= 4 * 1024**3]
    assert family(fits[-1]).dimension == dimension(fits[-1]) <= MOST_GENERATORS
    for size in (fits[-1] + 1, 3000, 2**63, 10**400, True, "3"):
        with pytest.raises(ParameterError) as caught:
            family(size)
        assert caught.value.name == "n"


def test_a_product_has_no_more_generators_than_the_largest_group():
    with pytest.raises(ParameterError) as caught:
        product(SO(40), SO(40))
    assert caught.value.name == "dimension"
