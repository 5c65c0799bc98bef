# SPDX-License-Identifier: BSD-3-Clause
"""Errors to plant: in which file, what is replaced by what, and what would be wrong then.

`old` stands once in the file; run.py says where it does not any more. `further` names the tests that may see what the
unit tests of the layer do not.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Planted:
    """One error."""

    file: str
    old: str
    new: str
    why: str
    #: regular expression of tests beyond unit.<layer> and signorom-post's own
    further: str = ""

    @property
    def layer(self) -> str:
        """Folder below src, or `python`."""
        return self.file.split("/")[1] if self.file.startswith("src/") else "python"


SRC = "src/"
POST = "tools/signorom_post/src/signorom_post/"

PLANTED = [
    # base
    Planted(
        SRC + "base/statistics.f90",
        "1 + fraction * (size(sorted) - 1)",
        "fraction * size(sorted)",
        "another kind of quantile",
    ),
    Planted(
        SRC + "base/ties.f90",
        ".true., dim=1)",
        ".true., dim=1, back=.true.)",
        "the last of equal ones instead of the first",
    ),
    Planted(
        SRC + "files/checksum.c",
        "for (; i < n; i++) a = mix",
        "for (; i + 1 < n; i++) a = mix",
        "the last number of a record is not part of its hash",
    ),
    Planted(
        SRC + "files/hdf5_header.c",
        "n_values <= (size - at) / value_size",
        "n_values <= size / value_size",
        "values of an attribute may stand behind it",
    ),
    Planted(
        SRC + "files/file_seal.c",
        "if (status == SIG_SEAL_FINE && hash != sealed_hash)",
        "if (status == SIG_SEAL_FINE && hash == 0)",
        "a changed byte breaks no seal",
    ),
    # dense
    Planted(
        SRC + "dense/bits.f90",
        "(n_flags + word_size - 1) / word_size",
        "n_flags / word_size + 1",
        "a word too many for 32 flags",
    ),
    Planted(
        SRC + "dense/nnls.f90",
        "gradient_tolerance = 1.0e-12_rk",
        "gradient_tolerance = 1.0e-5_rk",
        "least squares that stop before they are least",
    ),
    Planted(
        SRC + "dense/contact_error_bound.f90",
        "sqrt(square / 4 + dot_product(lambda, opening - misfit) + more)",
        "sqrt(square / 4 + more)",
        "the bound forgets forces across open gaps",
    ),
    Planted(
        SRC + "dense/lcp_block_pivoting.f90",
        "is_violated(i_last) = .true.",
        "is_violated(i_last) = .false.",
        "the rule that ends every cycle exchanges nothing",
    ),
    Planted(
        SRC + "dense/dense_factors.c",
        "pivots[k] += n_1;",
        "pivots[k] += k % 31 ? n_1 : 0;",
        "every 31st row exchange of the right half is forgotten",
    ),
    Planted(
        SRC + "dense/dense_condition.c",
        "return 2 * sig_sum_of_sizes",
        "return 20 * sig_sum_of_sizes",
        "condition numbers ten times too large",
    ),
    # online
    Planted(
        SRC + "solver/contact_responses.F90",
        "rounding * largest(1, :)",
        "rounding * maxval(largest)",
        "forces are rounding beside those of a column in another unit",
    ),
    Planted(
        SRC + "online/forest.f90",
        "/ (self%highest - self%lowest)",
        "/ (self%highest + self%lowest)",
        "the forest sees other features than in its training",
    ),
    Planted(
        SRC + "online/forest.c",
        "(float)point[",
        "point[",
        "the forest compares in double where scikit-learn compares in float",
    ),
    Planted(
        SRC + "online/multiplier_fit.f90",
        "call add_lifted(cluster, self%displacement_scale,",
        "call add_lifted(cluster, 1.0_rk,",
        "the driven part of displacements has another unit in the fit",
    ),
    Planted(
        SRC + "online/hhr_stiffness.f90",
        "moduli(i) = young / (2 * (1 - poisson))",
        "moduli(i) = young / (3 * (1 - 2 * poisson))",
        "plane stress takes the bulk modulus of space",
    ),
    Planted(
        SRC + "online/hhr_system.f90",
        "call multiply(1.0_rk, cluster%varying%lifting_parts, self%moduli, 0.0_rk, flat)",
        "flat = 0",
        "the lifting has no forces where the stiffness depends on the parameters",
    ),
    Planted(
        SRC + "online/grid_cells.f90",
        "position - 1) / n)**2",
        "position - 1))**2",
        "distances to cells count layers instead of sides of the box",
    ),
    Planted(
        SRC + "online/fixed_compliance.f90",
        "displacement - dot_product(self%contact_response(i_exact, :), unknowns)",
        "displacement + dot_product(self%contact_response(i_exact, :), unknowns)",
        "the displacement at one dof of a condensed answer has the wrong sign of the contact forces",
    ),
    Planted(
        SRC + "terms/window_rule.f90",
        "high <= window%minimum .or. low >= window%maximum",
        "high < window%minimum .or. low > window%maximum",
        "a facet that only touches the window counts as cut: its part there has no area",
    ),
    # spectral
    Planted(
        SRC + "spectral/singular_update.f90",
        "root = hypot(poles(1), weights(1))",
        "root = poles(1) + abs(weights(1))",
        "the only singular value with one column more adds lengths instead of squares",
    ),
    # parallel
    Planted(
        SRC + "parallel/error_broadcast.F90",
        "numbers = [error%line, error%column, error%exit_code]",
        "numbers = [error%line, error%line, error%exit_code]",
        "the column of an error is lost on its way to the ranks",
    ),
    Planted(
        SRC + "parallel/error_broadcast.F90",
        "last = min(first + step - 1, length)",
        "last = min(first + step - 2, length)",
        "the last byte of each piece of a long text does not arrive",
    ),
    # deck
    Planted(
        SRC + "deck/deck_checks.f90",
        "-1.0_rk, 0.5_rk, ''",
        "-1.0_rk, 0.6_rk, ''",
        "a Poisson ratio above 1/2 is accepted",
    ),
    Planted(
        SRC + "deck/value_products.f90",
        "if (cuts(i) > 0) call negate_after(operators(cuts(i):cuts(i)), own)",
        "if (cuts(i) > 0) call negate_after('+', own)",
        "an addend behind a minus is added",
    ),
    # mesh
    Planted(
        SRC + "mesh/cell_quality.f90",
        "+ matrix(1, 3) * (matrix(2, 1)",
        "- matrix(1, 3) * (matrix(2, 1)",
        "a determinant in space has the wrong sign of a minor",
    ),
    Planted(
        SRC + "mesh/mesh_build.f90",
        "length_factor * raw%coordinates(",
        "raw%coordinates(",
        "coordinates stay in the unit of the mesh file",
    ),
    Planted(
        SRC + "mesh/gmsh_sections.c",
        "*tag = abs(*tag);",
        "*tag = *tag;",
        "turned entities leave their physical group",
    ),
    Planted(
        SRC + "mesh/mesh_axis.f90",
        "< -rounding * maxval",
        "< rounding * maxval",
        "a mesh that touches the axis of symmetry is refused",
        "verification.test_(sphere|patch_models)|integration.test_decks",
    ),
    Planted(
        SRC + "mesh/mesh_file.f90",
        "if (raw%group_kinds(group) /= kind_entity) has_physical",
        "if (raw%group_kinds(group) == kind_named) has_physical",
        "an entity and a physical group without a name get one name",
    ),
    # fem
    Planted(
        SRC + "elements/shape_functions.f90",
        "slopes = [0.0_rk, place(2), place(1), place(1) * place(2)]",
        "slopes = [0.0_rk, place(1), place(2), place(1) * place(2)]",
        "gradients of pyramids exchange xi and eta",
    ),
    Planted(
        SRC + "elements/changed_basis.f90",
        "matrix(ends, i) = alpha",
        "matrix(i, ends) = alpha",
        "mid-side nodes get part of the corners in place of the other way round",
    ),
    Planted(
        SRC + "mechanics/elasticity.f90",
        "sum(stresses(4:6, :)**2",
        "sum(stresses(4:5, :)**2",
        "von Mises forgets yz",
    ),
    Planted(
        SRC + "fem/strain_maps.f90",
        "if (body%material_of_cell(i) /= map%materials(nodes(n))) cycle",
        "if (body%material_of_cell(i) == 0) cycle",
        "stresses at a node mix materials",
    ),
    Planted(
        SRC + "fem/strain_maps.f90",
        "where (totals > 0) at_nodes = at_nodes / totals",
        "where (totals > 0) at_nodes = 2 * at_nodes / totals",
        "stresses at nodes lack twice the imposed strains",
        "unit.fem.test_imposed_strain",
    ),
    Planted(
        SRC + "dense/lcp_rounding.f90",
        "forces(k) * softest <= tolerance *",
        "forces(k) * softest <= 0 * tolerance *",
        "rounding on an open contact closes it",
        "unit.dense.test_lcp_rounding",
    ),
    Planted(
        SRC + "fem/surface_measure.f90",
        "dot_product(tangents(:, 1), tangents(:, 2))**2))",
        "0 * dot_product(tangents(:, 1), tangents(:, 2))**2))",
        "skewed facets are too large",
        "verification.test_(sphere|blocks)",
    ),
    Planted(
        SRC + "fem/reactions.f90",
        "mask=is_free(dofs))",
        "mask=is_free(dofs) .or. .true.)",
        "a corner counts in two reactions",
    ),
    Planted(
        SRC + "fem/body_load.f90",
        "volume = volume * circumference(body%mechanics, place)",
        "volume = volume * circumference(body%mechanics, place) / place(1)",
        "body forces in axisymmetry forget the radius",
        "verification.test_loads",
    ),
    Planted(
        SRC + "online/field_map.f90",
        "call rows%fill_stresses(of_materials, strains - imposed, stresses)",
        "call rows%fill_stresses(of_materials, strains, stresses)",
        "stresses keep the imposed strains",
        "verification.test_imposed_strains",
    ),
    Planted(
        SRC + "fem/strain_parts.f90",
        "part%direction(i) = merge(1, 2, i <= 3)",
        "part%direction(i) = 1",
        "an imposed shear is half as large",
        "integration.test_imposed_strains",
    ),
    Planted(
        SRC + "fem/strain_parts.f90",
        "products(i)%values = products(i)%values + values",
        "products(i)%values = values",
        "a reference temperature takes the place of the constant part",
        "verification.test_imposed_strains",
    ),
    Planted(
        SRC + "fem/imposed_energy.f90",
        "energies = energies + volume / 2 * matmul",
        "energies = energies + volume * matmul",
        "the energy of imposed strains is twice as large",
        "integration.test_imposed_strains",
    ),
    Planted(
        SRC + "mesh/nodal_field.f90",
        "if (tags(order(j)) < tags(half(i))) then",
        "if (tags(order(j)) > tags(half(i))) then",
        "node numbers are sorted the wrong way",
        "integration.test_imposed_strains",
    ),
    # contact
    Planted(
        SRC + "contact/facet_bulges.f90",
        "i = minloc(abs(rises)",
        "i = maxloc(abs(rises)",
        "an edge beside a bend becomes an arc",
    ),
    Planted(
        SRC + "contact/node_gaps.f90",
        "shape%values(place)) + bulge * outward)",
        "shape%values(place)) - bulge * outward)",
        "the second surface bulges the wrong way",
        "unit.contact.test_node_gaps|verification.test_mortar_curved",
    ),
    Planted(
        SRC + "contact/mortar_sums.f90",
        "if (self%lowest(node) >= 0) mean_gap = max(0.0_rk, mean_gap)",
        "mean_gap = max(min(0.0_rk, self%lowest(node)), mean_gap)",
        "where the surfaces overlap a mean gap is not below the smallest one",
        "unit.contact.test_node_gaps",
    ),
    Planted(
        SRC + "contact/mortar_entries.f90",
        "if (any(abs(factors - spread(factors(1, :), 1, 3)) > 0)) return",
        "if (any(abs(factors) > 0)) return",
        "a gap with a parameter that is the same everywhere lets touching sides press",
        "unit.contact.test_mortar",
    ),
    Planted(
        SRC + "contact/mortar_rows.f90",
        "if (entry%has_direction) entry%direction = -entry%direction",
        "if (.not. entry%has_direction) entry%direction = [0.0_rk, -1.0_rk]",
        "swapped sides keep the direction of the deck",
        "integration.test_swapped_sides",
    ),
    Planted(
        SRC + "workflow/resultants_of_contact.f90",
        "map%unit_moments(:, k) = map%unit_imbalances(:, k) - map%unit_moments(:, k)",
        "map%unit_moments(:, k) = map%unit_moments(:, k)",
        "where sides were swapped the moment is that on the second surface",
        "integration.test_swapped_sides",
    ),
    Planted(
        SRC + "full_order/contact_building.f90",
        "      terms = terms_before\n      rows = pair_rows\n",
        "      if (.not. allocated(first_error)) rows = pair_rows\n",
        "contacts that are tried anew keep the rows of the last attempt",
        "integration.test_swapped_sides",
    ),
    Planted(
        SRC + "contact/row_condition.f90",
        "if (j > 1) next = next - beside * last",
        "if (j > 2) next = next - beside * last",
        "the second direction of the search keeps part of the first",
    ),
    Planted(
        SRC + "contact/obstacle_gap.f90",
        "if (.not. abs(direction(i)) < 1) cycle",
        "if (.not. abs(direction(i)) < 1 .or. i == 2 .and. size(direction) == 3) cycle",
        "the distance from a sphere's axis forgets y in space",
        "verification.test_(sphere|obstacles)|integration.test_obstacles",
    ),
    Planted(
        SRC + "contact/obstacle_gap.f90",
        "wave_start = '0.01'",
        "wave_start = '0.02'",
        "a sphere goes over into the plane around it with a jump",
    ),
    Planted(
        SRC + "contact/initial_gap.f90",
        "pairs%initial_gap(member) = pairs%initial_gap(member) + factor",
        "pairs%initial_gap(member) = factor",
        "of an obstacle's gap only the part that depends on the place is left",
        "integration.test_obstacles",
    ),
    Planted(
        SRC + "contact/contact_residuals.F90",
        "max(sizes%gap, displacement_size))",
        "sizes%gap)",
        "the residual of complementarity is relative to gaps that may be zero",
        "verification.test_blocks",
    ),
    Planted(
        SRC + "contact/contact_residuals.F90",
        "sums(n + 2) = sums(n + 2) + abs(load(loaded(i)))",
        "sums(n + 2) = sums(n + 2) + load(loaded(i))",
        "the size of loads in the balance of forces cancels",
    ),
    Planted(
        SRC + "contact/leaning_rows.f90",
        "leans(k) = min(leans(k), lean_of(normal_of_row(rows, k), common))",
        "leans(k) = max(leans(k), lean_of(normal_of_row(rows, k), common))",
        "the normals of two equal discs count as wrong by the whole angle between them",
        further="integration.test_leaning_contacts",
    ),
    Planted(
        SRC + "contact/rigid_bodies.f90",
        "modes(:, 5) = [place(3), 0.0_rk, -place(1)]",
        "modes(:, 5) = [place(3), 0.0_rk, place(1)]",
        "a rotation about y that is none",
    ),
    Planted(
        SRC + "mechanics/contact_rows.f90",
        "sign(norm2(coefficients), dot_product(coefficients, self%coefficients(first:first + self%n_dim - 1)))",
        "sign(norm2(coefficients), merge(1, -1, i <= n_first) * 1.0_rk)",
        "shares that pull push",
    ),
    Planted(
        SRC + "mechanics/nodal_values.f90",
        "associate (weight => rows%areas(k) * abs(shares(size(shares) - size(nodes) + 1:)))",
        "associate (weight => rows%areas(k) * shares(size(shares) - size(nodes) + 1:))",
        "the mean pressure at a node of the second side is no mean where shares are negative",
    ),
    Planted(
        SRC + "contact/mortar_entries.f90",
        "weights(i) * dot_product(sites%normal(:, own(i)), sites%normal(:, k))",
        "weights(i)",
        "gaps of corners count in full where the normal turns: the pressure of a shrink fit on T10 waves",
    ),
    Planted(
        SRC + "contact/side_motions.f90",
        "followers%is_possible = n_met(rows%owners()) == next + 1",
        "followers%is_possible = n_met(rows%owners()) >= next",
        "an owner moves though a row that cannot follow meets it, too",
    ),
    Planted(
        SRC + "mechanics/contact_rows.f90",
        "part = -self%coefficients(i:i + self%n_dim - 1)",
        "part = self%coefficients(i:i + self%n_dim - 1)",
        "resultants of contacts are those on the second surface",
    ),
    # solver
    Planted(
        SRC + "solver/bound_form.F90",
        "if (self%levels(k) < i_level) cycle",
        "if (self%levels(k) > i_level) cycle",
        "the unknowns of corners are told from those of mid-side nodes that changed before",
    ),
    Planted(
        SRC + "solver/bound_form.F90",
        "self%shares(first:last) * values(j)",
        "0 * self%shares(first:last) * values(j)",
        "forces forget the nodes that rows share",
    ),
    Planted(
        SRC + "solver/holding.f90",
        "if (multipliers(k) <= multipliers(best)) cycle",
        "if (multipliers(k) >= multipliers(best)) cycle",
        "what is kept to hold a body is the row that pulls most",
    ),
    Planted(
        SRC + "solver/holding.f90",
        "reach = max(0.0_rk, opening(k)) / closing(k)",
        "reach = max(0.0_rk, opening(k))",
        "the first row that blocks a motion is the one with the smallest gap",
    ),
    Planted(
        SRC + "solver/solver_plan.f90",
        "is_possible = candidates%is_allowed .and. has_room(candidates%cost, sizes)",
        "is_possible = candidates%is_allowed",
        "the fastest solver whatever memory it needs",
    ),
    Planted(
        SRC + "solver/free_response.F90",
        "if (present(anchors)) forces = forces + balanced_load",
        "if (present(anchors)) forces = forces - balanced_load",
        "loads push the other way",
    ),
    Planted(
        SRC + "solver/active_set.F90",
        "(n_changed > 0 .and. n_changed < self%n_changed .and. state%n_iterations < usual_steps)",
        "(n_changed > 0 .and. state%n_iterations < usual_steps)",
        "coarse forces open and close the same contacts in turn",
    ),
    Planted(
        SRC + "solver/contact_levels.c",
        "PetscCall(VecScale(held_part, 1.0 - HELD_SHARE));",
        "PetscCall(VecScale(held_part, 0.5));",
        "held unknowns keep half of the coarse motions",
        "integration.test_multigrid",
    ),
    Planted(
        SRC + "solver/held_operator.c",
        "if (is_free[i] == 0.0) products[i] = d[i] * values[i];",
        "if (is_free[i] == 0.0) products[i] = 0.0;",
        "the operator of multigrid is singular at held unknowns",
        "integration.test_multigrid",
    ),
    Planted(
        SRC + "contact/obstacle_rows.f90",
        "changed(i) = areas(i) / owner_weight",
        "changed(i) = areas(i)",
        "mid-side nodes on an obstacle have the area of the unchanged basis",
        "(integration.test_obstacles|verification.test_.*(obstacle|patch|quadratic))",
    ),
    Planted(
        SRC + "dense/lcp_derivative.f90",
        "noise = noise + rounding * abs(matrix(:, k)) * z(k)",
        "noise = noise + rounding_of_data * abs(matrix(:, k)) * z(k)",
        "openings of bodies that only contact holds seem to graze",
    ),
    Planted(
        SRC + "contact/problem_sizes.f90",
        "matmul(abs(system%rows%gap), abs(theta))",
        "abs(matmul(system%rows%gap, theta))",
        "gaps whose terms cancel have no size",
    ),
    # snapshots
    Planted(
        SRC + "files/csv_fields.f90",
        "if (has_quotes .and. line(i:i) == '\"') is_inside",
        "if (line(i:i) == '\"') is_inside",
        "quotes count in the middle of a text, too",
    ),
    Planted(
        SRC + "snapshots/farthest_points.f90",
        "- place) / (box(2, :) - box(1, :)))**2)",
        "- place))**2)",
        "distances of points depend on the units of the parameters",
    ),
    Planted(
        SRC + "snapshots/snapshot_shard.c",
        "*n_dropped = (n_left + (int64_t)shard->record_bytes - 1) / (int64_t)shard->record_bytes;",
        "*n_dropped = n_left / (int64_t)shard->record_bytes;",
        "half a record is cut without a word",
    ),
    Planted(
        SRC + "snapshots/snapshot_store.f90",
        "if (column_of_point(i_point) == 0 .or. reasons(i_column) > 0)",
        "if (column_of_point(i_point) == 0)",
        "a point that failed first stays failed",
    ),
    Planted(
        SRC + "snapshots/parameter_space.f90",
        "i_value_0 / (n_values - 1)",
        "i_value_0 / n_values",
        "grids do not have equal steps",
    ),
    # reduction
    Planted(
        SRC + "online/body_modes.f90",
        "norm2(reduced) / sqrt(minval(ratios))",
        "norm2(reduced) / sqrt(maxval(ratios))",
        "bounds of displacements below their error where the elastic constants differ",
    ),
    Planted(
        SRC + "reduction/condensed/residual_triangle.F90",
        "if (square(1) >= square_before / 4 .or. square(1) <= dependent**2 * sizes(i)) exit",
        "exit",
        "bounds of displacements a hundred times too large: what is left of like columns is full of rounding",
    ),
    Planted(
        SRC + "online/body_compliance.f90",
        "2 * point%residual + sqrt(stiffest)",
        "0 * point%residual + sqrt(stiffest)",
        "bounds of displacements below their error where bodies have several interpolated constants",
        further="verification.test_interpolated_stiffness",
    ),
    Planted(
        SRC + "reduction/condensed/interpolation_residuals.F90",
        "share = 1 / s(1)",
        "share = 100 / s(1)",
        "bounds of forces below their error: the other bodies yield less than that",
        further="verification.test_interpolated_stiffness",
    ),
    Planted(
        SRC + "reduction/condensed/response_errors.f90",
        "if (answer%reason > 0 .and. self%is_answered(i)) changes",
        "if (.false.) changes",
        "nothing but the training points decides how many nodes an interpolation has",
        further="verification.test_interpolated_stiffness",
    ),
    Planted(
        SRC + "reduction/pod_rank.f90",
        "where (sizes > negligible * maxval(sizes))",
        "where (sizes > negligible)",
        "what is negligible depends on the unit of length",
    ),
    Planted(
        SRC + "reduction/hat_functions.f90",
        "merge(0.0_rk, normal, is_prescribed(dofs) .or.",
        "merge(0.0_rk, normal, is_prescribed(rows%dofs(rows%offsets(row) + 1:rows%offsets(row) + rows%n_dim)) .or.",
        "hats of the second side ask whether the first side is held",
    ),
    Planted(
        SRC + "reduction/projection.f90",
        "if (place_in_ascending(domain%interior_dofs, loads%dofs(i)) == 0) cycle",
        "if (place_in_ascending(domain%interior_dofs, loads%dofs(i)) < 0) cycle",
        "loads outside of the reduced domain count",
        "verification.test_loads",
    ),
    Planted(
        SRC + "reduction/clustering/silhouette.c",
        "sums[own] / (sizes[own] - 1)",
        "sums[own] / sizes[own]",
        "a silhouette with itself as neighbor",
    ),
    Planted(
        SRC + "reduction/dirichlet_rows.f90",
        "sigma >= rank_tolerance * sigma(1))",
        "sigma >= rank_tolerance)",
        "the rank of the prescribed rows depends on the unit of length",
    ),
    # output
    Planted(
        SRC + "output/field_topology.f90",
        "nodes = nodes_of_cell(mesh, i_cell) - 1",
        "nodes = nodes_of_cell(mesh, i_cell)",
        "cells have nodes from 1",
        "integration.test_output",
    ),
    Planted(
        SRC + "output/field_topology.f90",
        "nodes = nodes(element_types(mesh%cell_types(i_cell))%output_order(:n_output_nodes(mesh%cell_types(i_cell))))",
        "nodes = nodes(:)",
        "T10, H20 and H27 keep gmsh's order in files for VTK",
        "verification.test_quadratic",
    ),
    Planted(
        SRC + "output/run_report.f90",
        "words(i)%text = to_text(value(i))",
        "words(i)%text = to_text(value(1))",
        "a list in the report repeats its first number",
        "integration.test_output",
    ),
    # workflow
    Planted(
        SRC + "workflow/validation/field_errors.f90",
        "comparison = comparison_t(abs(maxval(answered) - maxval(exact)), maxval(exact))",
        "comparison = comparison_t(maxval(answered) - maxval(exact), maxval(exact))",
        "a largest stress that is too small is no error",
    ),
    Planted(
        SRC + "workflow/validation/field_errors.f90",
        "if (second%size <= 0) worse = first",
        "worse = first",
        "smoothed stresses are not compared",
    ),
    Planted(
        SRC + "workflow/validation/verdict.f90",
        "of_energy <= limit .and. of_stress <= limit",
        "of_energy <= limit",
        "fields are accepted whatever the largest stress is",
    ),
    Planted(
        SRC + "workflow/validation/verdict.f90",
        "is_open .and. .not. is_of_field",
        "is_open",
        "a displacement that is no number is right where nothing touches",
    ),
    Planted(
        SRC + "workflow/validation/error_norms.F90",
        "%strain_energy(fields(:, i)) - dot_product(load(dofs), fields(dofs, i))",
        "%strain_energy(fields(:, i)) + 0 * sum(load(dofs))",
        "the energy on the reduced domain forgets the work of loads",
        "verification.test_(loads|half_disks)",
    ),
    Planted(
        SRC + "workflow/selection/greedy_rules.f90",
        "**(-1.0_rk / n_parameters) / 2",
        "**(-1.0_rk) / 2",
        "points of a batch may stand too close in several parameters",
        "integration.test_greedy",
    ),
    Planted(
        SRC + "workflow/selection/greedy_rules.f90",
        "do i = deck%greedy%n_initial + 1, n",
        "do i = deck%greedy%n_initial + 2, n",
        "a selection that is taken up again with another tolerance ends late",
        "integration.test_greedy",
    ),
    Planted(
        SRC + "workflow/refinement/candidate_pool.f90",
        "order(:(size(order) + 1) / 2)",
        "order(:size(order) / 2)",
        "half of one candidate is none",
        "integration.test_refinement",
    ),
    Planted(
        SRC + "full_order/contact_summary.f90",
        "any(abs(gaps) > 0, dim=2)",
        "[(i == 1, i=1, size(gaps, 1))]",
        "gaps in the summary forget the parameters",
        "integration.test_(initial_gap|obstacles|usage)",
    ),
    # app
    Planted(
        SRC + "dense/friction_types.f90",
        "if (force > radius) y = radius * (y / force)",
        "if (force > radius) y = 0.9_rk * radius * (y / force)",
        "a contact slips at nine tenths of its friction",
        "unit.dense.test_friction_problem",
    ),
    Planted(
        SRC + "dense/friction_problem.f90",
        "workspace%free(first:last) + origins(first:last)",
        "workspace%free(first:last)",
        "slip has no memory of its origin",
        "unit.dense.test_friction_problem",
    ),
    Planted(
        SRC + "dense/friction_newton.f90",
        "[1.0_rk, friction(k) * d(:size(rows))], 1, n)",
        "[1.0_rk, -friction(k) * d(:size(rows))], 1, n)",
        "Newton's friction pushes where it should hold",
        "unit.dense.test_friction_problem",
    ),
    Planted(
        SRC + "contact/tangential_rows.f90",
        "    rows%gap = 0\n",
        "",
        "a tangential row has the gap of its contact",
        "unit.contact.test_tangential_rows",
    ),
    Planted(
        SRC + "contact/tangential_rows.f90",
        "is_kept = .not. all_rows%are_inert(is_prescribed)",
        "is_kept = .true.",
        "tangential rows of prescribed nodes stay",
        "unit.contact.test_tangential_rows",
    ),
    Planted(
        SRC + "terms/history.f90",
        "if (i == 0) then\n      value = values(1)",
        "if (i == 0) then\n      value = 0",
        "a table is 0 before its first node",
        "unit.terms.test_history",
    ),
    Planted(
        SRC + "terms/history.f90",
        "growth**(real(i - 1, rk) / (n - 1))",
        "growth**(real(i - 1, rk) / n)",
        "the last increment of a step is not growth times the first",
        "unit.terms.test_history",
    ),
    Planted(
        SRC + "terms/history.f90",
        "if (self%nodes(1, i) > self%nodes(1, i - 1)) cycle",
        "if (self%nodes(1, i) >= self%nodes(1, i - 1)) cycle",
        "two nodes of a table may have the same time",
        "unit.terms.test_history",
    ),
    Planted(
        SRC + "online/query.f90",
        "state(size(self%parameters) + 2:) = tables",
        "state(size(self%parameters) + 2:) = state(size(self%parameters) + 2:)",
        "measured tables are ignored",
        "integration.test_history",
    ),
    Planted(
        SRC + "output/field_file.f90",
        "if (self%time_offset + parameters(self%i_time) <= self%time) self%time_offset = self%time",
        "if (self%time_offset + parameters(self%i_time) < 0) self%time_offset = self%time",
        "times of a second history begin again in viewers",
        "integration.test_history",
    ),
    Planted(
        SRC + "workflow/force_columns.f90",
        "to_text(count(normal > 0))",
        "to_text(count(normal >= 0))",
        "predict counts open contacts as active",
        "integration.test_predict",
    ),
    Planted(
        SRC + "app/answer_block.f90",
        "self%is_outside(i) = .not. asker%answer%is_inside_box",
        "self%is_outside(i) = .false.",
        "predict does not tell of points outside of the box",
        "integration.test_predict",
    ),
    Planted(
        SRC + "app/command_line.f90",
        "n_threads < 1 .or. n_threads > most_threads",
        "n_threads < 1 .or. n_threads > most_threads + 1",
        "one thread more than is allowed",
        "integration.test_predict",
    ),
    Planted(
        SRC + "app/session.F90",
        "    else if (is_stopped) then\n      call self%stop(text)\n",
        "",
        "a stage that a signal stopped looks finished",
        "integration.test_restart",
    ),
    # the set-up before it is solved
    Planted(
        SRC + "output/cell_collection.f90",
        "      n = n + sizes(i)\n      offsets(i) = n",
        "      offsets(i) = n\n      n = n + sizes(i)",
        "cells begin where they end",
    ),
    Planted(
        SRC + "workflow/check_fields.f90",
        "normals(:, owners(k)) = own / norm2(own)",
        "normals(:, owners(k)) = -own / norm2(own)",
        "check shows normals that point backwards",
        "integration.test_check_fields",
    ),
    Planted(
        SRC + "workflow/check_fields.f90",
        "side(rows%second_nodes_of(k)) = 2",
        "side(rows%second_nodes_of(k)) = 1",
        "check shows the second surface as the first",
        "integration.test_check_fields",
    ),
    Planted(
        SRC + "mesh/folded_surface.f90",
        "normals(:, others(k))) > opposite) cycle",
        "normals(:, others(k))) < opposite) cycle",
        "a surface that is folded onto itself is accepted",
        "integration.test_bad_surfaces",
    ),
    Planted(
        SRC + "reduction/hhr/zone_nodes.f90",
        "      if (is_valid) is_used = ",
        "      if (.not. is_valid) exit\n      is_used = ",
        "a corner of the box without finite loads hides the later ones",
        "unit.reduction.test_zone_nodes",
    ),
    Planted(
        SRC + "workflow/sampling/snapshot_merge.F90",
        "reported%is_reported = .true.",
        "reported%is_reported = .false.",
        "a damaged shard is reported twice",
        "integration.test_restart",
    ),
    Planted(
        POST + "plots/check_bodies.py",
        "arrows.outward)[chosen] < 0.0",
        "arrows.outward)[chosen] > 0.0",
        "arrows of a pressure stand inside the body",
    ),
    Planted(
        POST + "plots/loads.py",
        "is_loaded[cell].all()",
        "is_loaded[cell].any()",
        "a facet beside the load takes a part of it",
    ),
    Planted(
        POST + "plots/depth_buffer.py",
        "np.lexsort((-triangles, depth))",
        "np.lexsort((-triangles, -depth))",
        "far parts of a body hide near ones",
    ),
    Planted(
        POST + "plots/multipliers.py",
        "surfaces.pressures if surfaces",
        "surfaces.forces if surfaces",
        "nodal forces of quadratic facets alternate in the picture",
    ),
    Planted(
        POST + "paraview_script.py",
        "scene.AnimationTime = TIME",
        "scene.AnimationTime = 1.0",
        "ParaView draws the first point, whichever was asked for",
    ),
    Planted(
        POST + "plots/vtk_camera.py",
        "SIZE[1] - caption_strip]",
        "SIZE[1]]",
        "the caption stands on tall bodies",
    ),
    Planted(
        POST + "plots/solid_figures.py",
        "nodes_of()).all(axis=1)",
        "nodes_of()).any(axis=1)",
        "faces beside a contact are colored by its pressure",
    ),
    Planted(
        SRC + "dense/lcp_derivative.f90",
        "derivative%unknowns(active, :) = -factors%solve",
        "derivative%unknowns(active, :) = factors%solve",
        "derivatives of contact forces have the wrong sign",
    ),
    Planted(
        SRC + "dense/lcp_derivative.f90",
        "unknowns(active) = unknowns(active) - matmul(coupling",
        "unknowns(active) = unknowns(active) + matmul(coupling",
        "a grazing contact that closes relieves the others in the wrong sense",
    ),
    Planted(
        SRC + "dense/lcp_derivative.f90",
        "z(n + 1:) = z(n + 1:) - solution%lambda",
        "z(n + 1:) = z(n + 1:) + solution%lambda",
        "a body that no contact force holds moves one way only",
    ),
    Planted(
        SRC + "online/free_motions.f90",
        "size(forces))], forces > 0))",
        "size(forces))], forces >= 0))",
        "contacts without a force hold bodies",
    ),
    Planted(
        SRC + "terms/term_derivatives.f90",
        "slopes = (8 * (values(:, 1) - values(:, -1)) - ",
        "slopes = (8 * (values(:, 1) - values(:, -1)) + ",
        "slopes of terms are four thirds of what they are",
    ),
    Planted(
        SRC + "online/body_response.f90",
        "(theta_change(above) - constants(i) * theta_change(below))",
        "(theta_change(above) + constants(i) * theta_change(below))",
        "a ratio of moduli changes in the wrong sense with its denominator",
        "integration.test_gradients",
    ),
    Planted(
        SRC + "online/body_modes.f90",
        "bulk_slope = 2 / (1 - 2 * theta(nu))",
        "bulk_slope = 1 / (1 - 2 * theta(nu))",
        "the bulk modulus changes half as much with Poisson's ratio",
        "integration.test_gradients",
    ),
    Planted(
        SRC + "mesh/facing_groups.f90",
        "dot_product(normal, across) > opposite",
        "dot_product(normal, across) < opposite",
        "init guesses contacts between surfaces that look the same way",
        "integration.test_init",
    ),
    Planted(
        SRC + "fem/load_pattern.f90",
        "where (abs(forces) <= rounding",
        "where (abs(forces) < -rounding",
        "rounding of loads that cancel pulls a body off its contacts",
        "integration.test_imposed_strains",
    ),
    # Python tool
    Planted(
        POST + "mesh.py", "edges[counts == 1]", "edges[counts >= 1]", "inner edges are drawn as the boundary"
    ),
    Planted(
        POST + "mesh.py",
        "for i in range(1, len(cell) - 1)]",
        "for i in range(1, 2)]",
        "quadrilaterals lose a triangle",
    ),
    Planted(
        POST + "forest.py",
        "labels.min() < 1:",
        "labels.min() < 0:",
        "cluster 0 in a table of labels is accepted",
    ),
    Planted(
        POST + "arrays.py",
        'if mantissa == "1.0" else',
        'if mantissa == "1.1" else',
        "powers of ten are shown as 1.0 x 10^n",
    ),
]
