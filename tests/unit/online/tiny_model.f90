! SPDX-License-Identifier: BSD-3-Clause
!> A model small enough to be answered by hand.
module tiny_model
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_body_compliance, only: body_compliance_t
  use sig_condensed_model, only: condensed_model_t
  use sig_contact_rows, only: contact_rows_t, create_contact_rows
  use sig_elasticity, only: n_stresses
  use sig_field_map, only: field_map_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model
  use sig_hhr_data, only: hhr_data_t
  use sig_model, only: contact_side_t, model_t
  use sig_model_parts, only: compliance_of, set_clusters, set_fallback
  use sig_reduced, only: reduced_t
  use sig_strain_map, only: strain_map_t
  use sig_term_set, only: start_terms
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: build_tiny_model, add_full_order, condensed_of, build_interpolated_model, add_fields, build_field_map

contains

  !> Two modes, two of three multipliers in the domain, terms 1 and `squeeze`, box [0, 4].
  !>
  !> K_r = (2 -1; 1 1) is not symmetric, M the identity, F = squeeze (6, 3), D = (1, 2):
  !> - squeeze = 0.1: K_r^-1 F = squeeze (3, 0), both open;
  !> - squeeze = 1/2: row 1 closes: gamma_1 = 1, gamma_2 = 3/2 - 1 = 1/2, lambda_1 = 3 - 2 + 1/2 = 3/2;
  !> - squeeze = 2: both close: gamma = (1, 2), lambda = F - K_r gamma = (12, 6) - (0, 3) = (12, 3).
  subroutine build_tiny_model(model)
    type(model_t), intent(out) :: model
    type(hhr_data_t) :: cluster
    integer :: i_term

    model%code_version = '0.1.0'
    model%deck_text = 'title: tiny' // new_line('a') // 'mesh: {}' // new_line('a')
    model%title = 'tiny'
    model%provenance = '0123456789abcdef'
    model%mesh_hash = 'fedcba9876543210'
    model%length_unit = 'mm'
    model%force_unit = 'N'
    model%parameter_names = [string_t('squeeze')]
    model%parameter_units = [string_t('mm')]
    model%box = reshape([0.0_rk, 4.0_rk], [2, 1])
    model%training_points = reshape([0.0_rk, 2.0_rk, 4.0_rk], [1, 3])
    call start_terms(model%parameter_names, [string_t('x'), string_t('y')], .false., model%terms)
    call model%terms%add_expression('squeeze', 0, 0, i_term)
    model%n_nodes = 2
    model%n_dofs = 4
    model%n_dim = 2
    model%n_multipliers = 3
    model%first_side = contact_side_t([0, 1, 2, 3], [11, 12, 13], [1.0_rk, 1.0_rk, 1.0_rk], &
      reshape([0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk, 2.0_rk, 0.0_rk], [2, 3]))
    model%second_side = contact_side_t([0, 2, 3, 3], [21, 22, 22], [0.3_rk, 0.7_rk, 1.0_rk], &
      reshape([0.0_rk, 0.5_rk, 1.0_rk, 0.25_rk, 1.0_rk, 0.25_rk], [2, 3]))
    model%areas = [0.5_rk, 1.0_rk, 0.5_rk]
    model%resultants%names = [string_t('low - high'), string_t('low - rigid sphere')]
    model%resultants%entries = [1, 1, 2]
    model%resultants%unit_forces = reshape([0.0_rk, -1.0_rk, 0.6_rk, -0.8_rk, 1.0_rk, 0.0_rk], [2, 3])
    model%resultants%unit_moments = reshape([0.0_rk, -0.8_rk, -3.0_rk], [1, 3])
    model%resultants%unit_imbalances = reshape([0.0_rk, 0.1_rk, 0.0_rk], [1, 3])
    model%gap = reshape([1.0_rk, 3.0_rk, 2.0_rk, 0.0_rk, 0.0_rk, 0.0_rk], [3, 2])
    model%pod_tolerance = 1.0e-8_rk
    model%dirichlet = 'elastic_lifting'
    call build_cluster(cluster)
    call set_clusters(model, [cluster])
  end subroutine build_tiny_model

  !> Contact of all three pairs as the full-order model would have it: W = diag(1, 2, 4), gaps without contact forces
  !> (1, 3, 2) - squeeze (4, 5, 6), displacement squeeze (1, 2, 3, 4) - (lambda_1, lambda_2, lambda_3, 0).
  !>
  !> squeeze = 1: gaps (1, 3, 2) - (4, 5, 6) = (-3, -2, -4), lambda = (3, 1, 1), u = (-2, 1, 2, 4).
  subroutine add_full_order(model)
    type(model_t), intent(inout) :: model
    type(condensed_model_t), allocatable :: condensed
    type(fixed_compliance_t), allocatable :: fixed
    class(reduced_t), allocatable :: fallback

    allocate (condensed, fixed)
    fixed%compliance = reshape([1.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 2.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 4.0_rk], [3, 3])
    fixed%free_opening = reshape([1.0_rk, 3.0_rk, 2.0_rk, -4.0_rk, -5.0_rk, -6.0_rk], [3, 2])
    fixed%exact_dofs = [1, 2, 3, 4]
    fixed%free_response = reshape([0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 1.0_rk, 2.0_rk, 3.0_rk, 4.0_rk], [4, 2])
    fixed%contact_response = reshape([1.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk, 0.0_rk, &
      0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk], [4, 3])
    call move_alloc(fixed, condensed%compliance)
    call move_alloc(condensed, fallback)
    call set_fallback(model, fallback)
  end subroutine add_full_order

  !> The fixed compliance of a part of a model; null where it is of another kind.
  function condensed_of(model, i_part) result(condensed)
    type(model_t), target, intent(in) :: model
    integer, intent(in) :: i_part
    type(fixed_compliance_t), pointer :: condensed

    condensed => null()
    select type (compliance => compliance_of(model, i_part))
    type is (fixed_compliance_t)
      condensed => compliance
    end select
  end function condensed_of

  !> One body with Young's modulus 2 + squeeze and Poisson's ratio nu = squeeze / 10, in place of all other parts.
  !>
  !> With s = (2 + squeeze) / 2: W = diag(1, 2, 4) (1 + nu) / s, gaps without contact forces
  !> (1, 3, 2) - squeeze (4, 5, 6) (1 + nu) / s, displacement squeeze (1, 2, 3, 4) / s - (lambda_1, lambda_2, lambda_3, 0) / s.
  !> Without contact the square of the displacement in the norm of the stiffness is 90 squeeze^2 (1 + nu) / s.
  subroutine build_interpolated_model(model)
    type(model_t), intent(out) :: model
    type(condensed_model_t), allocatable :: condensed
    type(body_compliance_t), allocatable :: interpolated
    real(rk) :: compliance(9), opening(6), field(8), contact_field(12), gap(3, 4), nu
    integer :: i, i_term

    call build_tiny_model(model)
    call model%terms%add_expression('2 + squeeze', 0, 0, i_term)
    call model%terms%add_expression('squeeze / 10', 0, 0, i_term)
    gap = 0
    gap(:, 1) = [1.0_rk, 3.0_rk, 2.0_rk]
    model%gap = gap
    allocate (interpolated)
    interpolated%gap = gap
    interpolated%exact_dofs = [1, 2, 3, 4]
    interpolated%start_sets = reshape([0, 7, 7], [1, 3])
    allocate (interpolated%bodies(1))
    associate (body => interpolated%bodies(1))
      body%modulus_term = 3
      body%modulus = 2
      body%numerators = [4]
      body%denominators = [0]
      body%own = [1, 2, 3, 4]
      call body%nodes%create([0.0_rk], [0.4_rk], 2)
      compliance = [1.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 2.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 4.0_rk]
      opening = [0.0_rk, 0.0_rk, 0.0_rk, -4.0_rk, -5.0_rk, -6.0_rk]
      field = [0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 1.0_rk, 2.0_rk, 3.0_rk, 4.0_rk]
      contact_field = [1.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk]
      allocate (body%compliance(9, 3), body%loaded_opening(6, 3), body%prescribed_opening(6, 3), body%loaded_field(8, 3))
      allocate (body%prescribed_field(8, 3), body%contact_field(12, 3), body%loaded_energy(4, 3), body%prescribed_energy(4, 3))
      body%prescribed_energy = 0
      body%prescribed_opening = 0
      body%prescribed_field = 0
      do i = 1, 3
        nu = sum(body%nodes%node(i))
        body%compliance(:, i) = compliance * (1 + nu)
        body%loaded_opening(:, i) = opening * (1 + nu)
        body%loaded_energy(:, i) = [0.0_rk, 0.0_rk, 0.0_rk, 90 * (1 + nu)]
        body%loaded_field(:, i) = field
        body%contact_field(:, i) = contact_field
      end do
      allocate (body%bound%residuals(7, 7), body%bound%rest(7, 7), body%bound%forces(3, 7))
      body%bound%place = 0.2_rk
      body%bound%residuals = 0
      body%bound%rest = 0
      body%bound%forces = 0
    end associate
    deallocate (model%parts)
    allocate (model%parts(1))
    allocate (condensed)
    call move_alloc(interpolated, condensed%compliance)
    call move_alloc(condensed, model%parts(1)%reduced)
  end subroutine build_interpolated_model

  subroutine build_cluster(cluster)
    type(hhr_data_t), intent(out) :: cluster

    cluster%n_modes = 2
    cluster%n_rows = 2
    cluster%basis = reshape([1.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.6_rk, 0.8_rk, 0.0_rk], [4, 2])
    cluster%lifting = reshape([0.5_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk, -1.0_rk], [4, 2])
    cluster%lifted_terms = [1, 2]
    cluster%reduced_stiffness = reshape([2.0_rk, 1.0_rk, -1.0_rk, 1.0_rk], [2, 2])
    cluster%contact_matrix = reshape([1.0_rk, 0.0_rk, 0.0_rk, 1.0_rk], [2, 2])
    cluster%load = reshape([0.0_rk, 0.0_rk, 6.0_rk, 3.0_rk], [2, 2])
    cluster%gap = reshape([1.0_rk, 2.0_rk, 0.0_rk, 0.0_rk], [2, 2])
    cluster%contact_rows = [1, 3]
    cluster%seed_nodes = [1]
    cluster%facing_nodes = [2]
    cluster%cells = [4, 5, 6]
    cluster%interior_dofs = [1, 2]
    cluster%interface_dofs = [3]
    cluster%contact_dofs = [2]
    ! Two snapshots; multiplier 2 is outside the domain.
    cluster%dual_snapshots = reshape([1.5_rk, 0.5_rk, 0.0_rk, 12.0_rk, 20.0_rk, 3.0_rk], [3, 2])
    cluster%contact_displacement_snapshots = reshape([1.0_rk, 0.5_rk, 1.0_rk, 2.0_rk], [2, 2])
    cluster%contact_value_basis = reshape([1.0_rk, 0.0_rk, 0.0_rk, 1.0_rk], [2, 2])
    cluster%contact_value_lifting = reshape([0.0_rk, 0.0_rk, 0.0_rk, 0.0_rk], [2, 2])
    cluster%singular_values = [3.0_rk, 1.0_rk, 1.0e-9_rk]
    cluster%condition_number = 1
    cluster%rank = 2
    cluster%stiffness_condition = 2.5_rk
    cluster%primal_rank_expected = 2
    cluster%stiffness_rank = 2
    cluster%basis_rank = 2
    ! the second mode is a hat on node 2, which makes the rank full
    cluster%n_pod_modes = 1
    cluster%n_hats = 1
    cluster%history%rows = [0, 3]
    cluster%history%nodes = [0, 2]
    cluster%history%n_columns = [1, 2]
    cluster%history%ranks = [1, 2]
    cluster%history%condition_numbers = [ieee_value(1.0_rk, ieee_positive_inf), 1.0_rk]
    cluster%history%singular_ratios = [1.0_rk, 1.0_rk]
    cluster%history%stiffness_conditions = [1.0_rk, 2.5_rk]
    cluster%warnings = [string_t('first sentence'), string_t('')]
  end subroutine build_cluster

  !> The same gradients in each row: the triangle itself, or its nodes.
  function strains_of(n_rows, nodes) result(map)
    integer, intent(in) :: n_rows
    integer, intent(in) :: nodes(3)
    type(strain_map_t) :: map
    integer :: i

    map%starts = [(3 * i, i=0, n_rows)]
    map%nodes = [(nodes, i=1, n_rows)]
    map%gradients = reshape([([real(rk) :: -1, -1, 0, 1, 0, 0, 0, 1, 0], i=1, n_rows)], [3, 3 * n_rows])
    map%materials = [(1, i=1, n_rows)]
    map%imposed = reshape([([real(rk) :: 1, 0, 0, 0, 0, 0], i=1, n_rows)], [n_stresses, n_rows])
    map%imposed_rows = [(i, i=1, n_rows)]
    map%imposed_terms = [(2, i=1, n_rows)]
    allocate (map%point_starts(n_rows + 1), source=0)
    allocate (map%points(0), map%point_weights(0))
  end function strains_of

  !> A triangle (0, 0), (1, 0), (0, 1) in plane strain with E = a and nu = 1/4, and a strain q imposed along x: all but the contact
  !> rows. Of two nodes the first one is the third one, too.
  subroutine build_field_map(parameter_names, q, a, n_nodes, map)
    type(string_t), intent(in) :: parameter_names(:)
    !> expressions
    character(*), intent(in) :: q, a
    integer, intent(in) :: n_nodes
    type(field_map_t), intent(out) :: map
    integer :: i_term

    map%mechanics = mechanical_model('plane_strain')
    map%stress_unit = 'MPa'
    map%area_unit = 'mm'
    map%of_cells = strains_of(1, [1, 2, modulo(2, n_nodes) + 1])
    map%of_nodes = strains_of(n_nodes, [1, 2, modulo(2, n_nodes) + 1])
    map%region_names = [string_t('block')]
    map%regions = [1]
    map%facet_starts = [0, 2]
    map%facet_nodes = [1, 2]
    map%facet_entries = [1]
    call start_terms(parameter_names, [string_t('x'), string_t('y')], .false., map%terms)
    call map%terms%add_expression(q, 0, 0, i_term)
    call map%terms%add_expression(a, 0, 0, i_term)
    call map%terms%add_expression('0.25', 0, 0, i_term)
    map%constant_terms = [3, 4]
  end subroutine build_field_map

  !> Fields of the tiny model on such a triangle.
  subroutine add_fields(model)
    type(model_t), intent(inout) :: model
    type(contact_rows_t) :: rows

    model%node_tags = [11, 12]
    model%coordinates = reshape([0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk], [2, 2])
    call build_field_map(model%parameter_names, 'squeeze / 8', '2 + squeeze', 2, model%fields)
    call create_contact_rows([1, 1, 1], [0, 0, 1], [1, 2, 1, 2], reshape([real(rk) :: 0, 1, 0, 1, 0, 1, 0, -1], [2, 4]), &
      model%gap, model%areas, model%resultants%entries, rows)
    call model%fields%set_rows(rows, 3)
  end subroutine add_fields
end module tiny_model
