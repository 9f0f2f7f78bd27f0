"""The rules in their order, each with the reason for its place.

A rule is a file beside this one and a line here.  One that comes later sees what those before it added.
What `search.options` adds is no rule: variants of every operation that is there, as a sum modulo a turn or an
angle in (-pi, pi], which say nothing of the problem.
"""

from __future__ import annotations

from cordicc.rewrite.rules.angle_sums import ANGLE_SUMS
from cordicc.rewrite.rules.circles import CIRCLES
from cordicc.rewrite.rules.common_denominators import COMMON_DENOMINATORS
from cordicc.rewrite.rules.completed_squares import COMPLETED_SQUARES
from cordicc.rewrite.rules.factor_orders import FACTOR_ORDERS, QUOTIENT_ORDERS
from cordicc.rewrite.rules.forms import FORMS
from cordicc.rewrite.rules.frames import FRAMES
from cordicc.rewrite.rules.half_sums import HALF_SUMS
from cordicc.rewrite.rules.hyperbolic_angles import HYPERBOLIC_ANGLES
from cordicc.rewrite.rules.mirrored_angles import MIRRORED_ANGLES
from cordicc.rewrite.rules.multiples import MULTIPLES
from cordicc.rewrite.rules.norms import NORM_CHAINS, NORMS
from cordicc.rewrite.rules.offsets import OFFSETS
from cordicc.rewrite.rules.perfect_squares import PERFECT_SQUARES
from cordicc.rewrite.rules.polar_vectors import SHARES_OF_NORMS, TURNED_VECTORS
from cordicc.rewrite.rules.principal_values import PRINCIPAL_VALUES
from cordicc.rewrite.rules.product_pairs import PRODUCT_PAIRS
from cordicc.rewrite.rules.root_chains import ROOT_CHAINS
from cordicc.rewrite.rules.roots_of_products import ROOTS_OF_PRODUCTS
from cordicc.rewrite.rules.rotation_chains import ROTATION_CHAINS
from cordicc.rewrite.rules.rule import Rule
from cordicc.rewrite.rules.shared_roots import SHARED_ROOTS
from cordicc.rewrite.rules.squares import SQUARES
from cordicc.rewrite.rules.unit_vectors import UNIT_VECTORS
from cordicc.rewrite.rules.vector_sums import VECTOR_SUMS

RULES: tuple[Rule, ...] = (
    HYPERBOLIC_ANGLES,  # joins what is equal before anything is made of it twice
    FORMS,  # sums and products of the realisations themselves; circles find theirs among them
    CIRCLES,  # of the angles that the realisations take, not of those that follow from them
    FRAMES,
    PRINCIPAL_VALUES,  # takes the equations of circles and frames too
    PERFECT_SQUARES,
    COMPLETED_SQUARES,
    ROOT_CHAINS,
    QUOTIENT_ORDERS,
    UNIT_VECTORS,  # of quotients that come from orders too
    SHARES_OF_NORMS,
    TURNED_VECTORS,
    OFFSETS,  # of these rotations too
    VECTOR_SUMS,
    SHARED_ROOTS,
    COMMON_DENOMINATORS,  # lifts every vectoring and equation that is there by now
    ROOTS_OF_PRODUCTS,  # common denominators are products of roots
    ANGLE_SUMS,  # of every angle that is there by now; the rules below add none but to turn by
    MIRRORED_ANGLES,
    NORMS,
    NORM_CHAINS,
    SQUARES,
    HALF_SUMS,
    ROTATION_CHAINS,  # takes the products that half sums leave
    MULTIPLES,  # from here on only products and sums that are there become fewer
    FACTOR_ORDERS,
    PRODUCT_PAIRS,
)
