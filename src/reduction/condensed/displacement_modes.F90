! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Displacements by modes where elastic constants depend on the parameters. For each body this module computes a basis from the
!> displacements of many states (sig_interpolated_fields), the reduced equations (Galerkin) for each part of the stiffness, and the
!> residuals that bound their error. sig_body_modes uses them.
!>
!> mu_0 are the elastic constants of a body for which the variables of its interpolation (body_constants_t) are in the middle of
!> their ranges. A part of the stiffness belongs to one modulus of one material.
module sig_displacement_modes
  use sig_body_constants, only: joined_body_t
  use sig_body_modes, only: body_modes_t, part_moduli
  use sig_body_nodes, only: close_anchors, dofs_of_body, responses_t, solve_node
  use sig_contact_responses, only: close_rows, measure_work
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: hooke_term, n_hooke_terms, n_stresses
  use sig_errors, only: error_t
  use sig_free_response, only: factor_without_contact, held_dofs
  use sig_full_order, only: team_t
  use sig_holding, only: anchors_t
  use sig_body_data, only: body_data_t
  use sig_energy_modes, only: product_of
  use sig_interpolated_fields, only: field_states_t, interpolate_fields
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_linear_solver, only: linear_solver_t
  use sig_petsc_support, only: broadcast_columns, multiply_block, sum_over_ranks
  use sig_problem, only: problem_t
  use sig_residual_triangle, only: find_triangle
  use sig_singular_values, only: svd
  use petsc
  implicit none(type, external)
  private
  public :: add_displacement_modes

  !> Columns that are spread over the ranks: the rows of this rank.
  type :: columns_t
    real(rk), allocatable :: values(:, :)
  end type columns_t

  !> [-] what modes leave of a state, over reduction.displacement_tolerance: the errors that answers tell are a few times as large,
  !> and other points have larger ones
  real(rk), parameter :: caution = 0.1_rk
  !> [-] modes with a smaller share of the energy of the first one are rounding
  real(rk), parameter :: rounding_of_energy = 1.0e-13_rk

contains

  !> Sets data%modes and data%mode_motions, and data%middle_compliance, which is empty where the data have a bound. Afterwards
  !> `joined` and the stiffness of the team are those of mu_0, where the variables of the interpolation are in the middle of their
  !> ranges. Collective on all ranks, with the same result on each.
  !>
  !> Errors: the stiffness could not be factored.
  subroutine add_displacement_modes(problem, team, joined, states, data, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(inout) :: joined
    !> whose displacements modes are chosen for
    type(field_states_t), intent(in) :: states
    class(body_data_t), intent(inout) :: data
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(responses_t) :: responses
    type(columns_t) :: bases(size(joined%constants)), forces(size(joined%constants))
    real(rk), allocatable :: fields(:, :)
    integer :: i

    PetscCall(interpolate_fields(problem, team, joined, states, data, fields, error, ierr))
    if (allocated(error)) return
    do i = 1, size(joined%constants)
      call joined%set(problem, i, (joined%constants(i)%lower + joined%constants(i)%upper) / 2)
    end do
    PetscCall(solve_node(problem, team, joined, data, responses, error, ierr))
    if (allocated(error)) return
    allocate (data%modes(size(joined%constants)))
    do i = 1, size(joined%constants)
      call take_materials(problem, joined, i, data%modes(i))
    end do
    PetscCall(find_bases(problem, team, responses, states, fields, data, bases, ierr))
    call move_all_dofs(team, responses, data)
    PetscCall(measure_parts(problem, team, joined, bases, forces, data, ierr))
    ! from here on the stiffness is that of mu_0 again
    PetscCall(solve_node(problem, team, joined, data, responses, error, ierr))
    if (allocated(error)) return
    PetscCall(measure_modes(team, responses, bases, forces, data, ierr))
  end subroutine add_displacement_modes

  !> Sets in `modes` the terms of Young's modulus and Poisson's ratio of each material of a body, and the bulk and shear modulus of
  !> each (part_moduli) at mu_0, where the variables of the interpolation are in the middle of their ranges. Local.
  subroutine take_materials(problem, joined, i_body, modes)
    type(problem_t), intent(in) :: problem
    !> its elastic constants are mu_0
    type(joined_body_t), intent(in) :: joined
    integer, intent(in) :: i_body
    type(body_modes_t), intent(inout) :: modes
    integer :: i, slot

    modes%is_thin = problem%body%mechanics%is_thin
    associate (materials => joined%constants(i_body)%materials)
      modes%modulus_terms = problem%constant_terms(2 * materials - 1)
      modes%ratio_terms = problem%constant_terms(2 * materials)
      allocate (modes%moduli(n_hooke_terms * size(materials)))
      do i = 1, size(materials)
        slot = joined%starts(i_body) + i
        modes%moduli(n_hooke_terms * i - 1:n_hooke_terms * i) = &
          part_moduli(joined%moduli(slot), joined%ratios(slot), modes%is_thin)
      end do
    end associate
  end subroutine take_materials

  !> Computes the basis of each body: the responses to prescribed displacements, then the modes. Sets dofs, lifted_terms and basis
  !> of data%modes(:). Collective on all ranks.
  subroutine find_bases(problem, team, responses, states, fields, data, bases, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    !> responses at mu_0, where the variables of the interpolation are in the middle of their ranges
    type(responses_t), intent(in) :: responses
    type(field_states_t), intent(in) :: states
    !> of interpolate_fields; changed
    real(rk), allocatable, intent(inout) :: fields(:, :)
    class(body_data_t), intent(inout) :: data
    !> basis of each body on the rows of this rank, zero outside of the body
    type(columns_t), intent(out) :: bases(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: lifting(:, :), modes(:, :)
    logical, allocatable :: is_own(:)
    integer, allocatable :: lifted(:)
    integer :: i, k, place(problem%mesh%n_dim * problem%mesh%n_nodes)

    ierr = 0
    associate (system => team%solver%system, prescribed => problem%boundary%prescribed_values)
      lifted = pack([(i, i=1, size(prescribed, 2))], any(abs(prescribed) > 0, dim=1))
      PetscCall(system%share_columns(responses%prescribed(:, lifted), size(lifted), lifting, ierr))
      PetscCall(broadcast_columns(lifting, PETSC_COMM_WORLD, ierr))
      do i = 1, size(bases)
        call leave_out_lifting(problem, team, responses, lifted, states, data, i, fields)
      end do
      do i = 1, size(bases)
        is_own = dofs_of_body(problem, i)
        associate (own => data%modes(i))
          own%dofs = pack([(k, k=1, size(is_own))], is_own)
          own%lifted_terms = lifted
          PetscCall(find_modes(problem, team, fields, is_own, own%dofs, modes, ierr))
          allocate (own%basis(size(own%dofs), size(lifted) + size(modes, 2)))
          own%basis(:, :size(lifted)) = lifting(own%dofs, :)
          own%basis(:, size(lifted) + 1:) = modes
          place = 0
          place(own%dofs) = [(k, k=1, size(own%dofs))]
          allocate (bases(i)%values(system%map%n_local_dofs, size(own%basis, 2)), source=0.0_rk)
          do k = 1, size(system%map%local_dofs)
            if (place(system%map%local_dofs(k)) > 0) bases(i)%values(k, :) = own%basis(place(system%map%local_dofs(k)), :)
          end do
        end associate
      end do
    end associate
  end subroutine find_bases

  !> Subtracts from the fields of one body the responses to prescribed displacements at mu_0. Local.
  subroutine leave_out_lifting(problem, team, responses, lifted, states, data, i_body, fields)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(in) :: team
    type(responses_t), intent(in) :: responses
    !> numbers of the terms of prescribed displacements
    integer, intent(in) :: lifted(:)
    type(field_states_t), intent(in) :: states
    class(body_data_t), intent(in) :: data
    integer, intent(in) :: i_body
    !> of interpolate_fields
    real(rk), intent(inout) :: fields(:, :)
    real(rk), allocatable :: own(:, :), theta(:, :)
    logical, allocatable :: is_own(:)
    integer, allocatable :: rows(:)
    integer :: i

    is_own = dofs_of_body(problem, i_body)
    theta = states%theta(lifted, :)
    do i = 1, size(theta, 2)
      theta(:, i) = sqrt(data%bodies(i_body)%modulus_ratio(states%theta(:, i))) / states%sizes(i) * theta(:, i)
    end do
    associate (local => team%solver%system%map%local_dofs)
      rows = pack([(i, i=1, size(local))], is_own(local))
    end associate
    own = fields(rows, :)
    call add_product(-1.0_rk, responses%prescribed(rows, lifted), theta, own)
    fields(rows, :) = own
  end subroutine leave_out_lifting

  !> Computes the modes of one body, the principal displacements of the states in the norm of K(mu_0), as many as the tolerance asks
  !> for. Collective on all ranks, with the same result on each. Requires: the stiffness of the team is that of mu_0.
  subroutine find_modes(problem, team, fields, is_own, dofs, modes, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(in) :: team
    !> displacements of the states over their sizes, without lifting; rows of this rank
    real(rk), contiguous, intent(in) :: fields(:, :)
    !> dofs of the body, natural: as flags of all dofs, and as numbers
    logical, intent(in) :: is_own(:)
    integer, intent(in) :: dofs(:)
    !> [length/sqrt(force*length)] orthonormal in the norm of K(mu_0), shape (size(dofs), n_modes)
    real(rk), allocatable, intent(out) :: modes(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: energy(:, :), u(:, :), s(:), vt(:, :), shared(:, :)
    integer :: i, n

    associate (system => team%solver%system, tolerance => caution * problem%deck%reduction%displacement_tolerance)
      PetscCall(measure_work(system, fields, energy, ierr, is_own))
      PetscCall(broadcast_columns(energy, PETSC_COMM_WORLD, ierr))
      call svd((energy + transpose(energy)) / 2, u, s, vt)
      n = number_of_modes(u, s, tolerance)
      do i = 1, n
        u(:, i) = u(:, i) / sqrt(s(i))
      end do
      PetscCall(system%share_columns(product_of(fields, u(:, :n)), n, shared, ierr))
      PetscCall(broadcast_columns(shared, PETSC_COMM_WORLD, ierr))
      modes = shared(dofs, :)
      do i = 1, size(dofs)
        if (system%boundary%is_prescribed(dofs(i))) modes(i, :) = 0
      end do
    end associate
  end subroutine find_modes

  !> Returns the smallest number of modes that leave at most the tolerance of each state.
  pure integer function number_of_modes(u, s, tolerance) result(n)
    !> eigenvectors of the products of the states, a state per row, and eigenvalues
    real(rk), intent(in) :: u(:, :)
    real(rk), intent(in) :: s(:)
    !> [-]
    real(rk), intent(in) :: tolerance
    real(rk) :: rest(size(u, 1))

    n = count(s > rounding_of_energy * maxval([0.0_rk, s]))
    rest = 0
    do while (n > 0)
      rest = rest + s(n) * u(:, n)**2
      if (maxval(rest) > tolerance**2) exit
      n = n - 1
    end do
  end function number_of_modes

  !> Sets data%mode_motions, the displacements of all dofs by the rigid motions of the anchors. Local.
  subroutine move_all_dofs(team, responses, data)
    type(team_t), intent(in) :: team
    type(responses_t), intent(in) :: responses
    class(body_data_t), intent(inout) :: data
    integer :: i

    associate (motions => team%solver%system%motions, anchors => responses%anchors)
      allocate (data%mode_motions(team%solver%system%map%n_dofs, size(anchors%rows)))
      do i = 1, size(anchors%rows)
        data%mode_motions(:, i) = motions%field(anchors%amplitudes(:, i))
      end do
    end associate
  end subroutine move_all_dofs

  !> Computes K_q V and, in data%modes(:)%stiffness, V'K_q V of all bodies for each part K_q of the stiffness at mu_0, where the
  !> variables of the interpolation are in the middle of their ranges. K_q has the modulus of mu_0, not the modulus 1. Changes the
  !> stiffness of the team. Collective on all ranks.
  subroutine measure_parts(problem, team, joined, bases, forces, data, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(in) :: joined
    !> V, of find_bases
    type(columns_t), intent(in) :: bases(:)
    !> [force] K_1 V, K_2 V, ... with zeros on held dofs, rows of this rank
    type(columns_t), intent(out) :: forces(:)
    class(body_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr
    type(elastic_body_t) :: law
    real(rk), allocatable :: product(:, :), stiffness(:, :)
    logical, allocatable :: is_held(:)
    integer :: i, i_part, n

    ierr = 0
    is_held = held_dofs(team%solver%system)
    do i = 1, size(bases)
      n = size(bases(i)%values, 2)
      allocate (forces(i)%values(size(bases(i)%values, 1), n * size(data%modes(i)%moduli)))
      allocate (data%modes(i)%stiffness(n**2, size(data%modes(i)%moduli)))
    end do
    do i_part = 1, maxval([(size(data%modes(i)%moduli), i=1, size(bases))])
      call take_part(joined, data, i_part, law)
      associate (system => team%solver%system)
        PetscCall(system%update_stiffness(problem%mesh, law, ierr))
        do i = 1, size(bases)
          if (i_part > size(data%modes(i)%moduli)) cycle
          n = size(bases(i)%values, 2)
          if (allocated(product)) deallocate (product)
          allocate (product, mold=bases(i)%values)
          PetscCall(multiply_block(system%stiffness, bases(i)%values, product, ierr))
          stiffness = transposed_product(bases(i)%values, product)
          PetscCall(sum_over_ranks(system%comm, stiffness, ierr))
          PetscCall(broadcast_columns(stiffness, PETSC_COMM_WORLD, ierr))
          data%modes(i)%stiffness(:, i_part) = reshape(stiffness, [n**2])
          forces(i)%values(:, (i_part - 1) * n + 1:i_part * n) = &
            merge(0.0_rk, product, spread(is_held(system%map%local_dofs), 2, n))
        end do
      end associate
    end do
  end subroutine measure_parts

  !> Sets the material law to part i_part of the stiffness of each body at mu_0 (data%modes(:)%moduli). Bodies with fewer parts
  !> get zero stiffness. Local.
  subroutine take_part(joined, data, i_part, law)
    type(joined_body_t), intent(in) :: joined
    class(body_data_t), intent(in) :: data
    !> 1-based among the parts of each body: bulk and shear modulus of its first material, then of the next ones
    integer, intent(in) :: i_part
    type(elastic_body_t), intent(out) :: law
    real(rk) :: hooke(n_stresses, n_stresses)
    integer :: i

    law = joined%body
    law%hooke = 0
    hooke = hooke_term(law%model, modulo(i_part - 1, n_hooke_terms) + 1)
    associate (strains => law%mechanics%strains(:law%mechanics%n_strains))
      do i = 1, size(data%modes)
        if (i_part > size(data%modes(i)%moduli)) cycle
        law%hooke(:, :, joined%starts(i) + (i_part - 1) / n_hooke_terms + 1) = &
          data%modes(i)%moduli(i_part) * hooke(strains, strains)
      end do
    end associate
  end subroutine take_part

  !> Sets loads, contact and residuals of data%modes(:), and data%middle_compliance where the data have no bound. Collective on all
  !> ranks.
  subroutine measure_modes(team, responses, bases, forces, data, ierr)
    type(team_t), intent(inout) :: team
    !> responses at mu_0 (the variables of the interpolation in the middle of their ranges), as the stiffness of the team must be
    type(responses_t), intent(in) :: responses
    !> of find_bases
    type(columns_t), intent(in) :: bases(:)
    !> of measure_parts
    type(columns_t), intent(in) :: forces(:)
    class(body_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver
    real(rk), allocatable :: driven(:, :), columns(:, :)
    integer :: i, n, n_driving

    n_driving = size(responses%loaded, 2)
    associate (system => team%solver%system)
      PetscCall(factor_without_contact(system, linear_solver, ierr))
      do i = 1, size(bases)
        n = n_driving + size(responses%contact, 2)
        allocate (driven(size(responses%loaded, 1), n_driving), columns(size(responses%loaded, 1), n + size(forces(i)%values, 2)))
        columns(:, :n_driving) = responses%loaded
        columns(:, n_driving + 1:n) = responses%contact
        call keep_body(team, data%modes(i)%dofs, columns(:, :n))
        PetscCall(multiply_block(system%stiffness, columns(:, :n_driving), driven, ierr))
        PetscCall(take_work(team, responses%anchors, bases(i)%values, driven, data%modes(i), ierr))
        PetscCall(linear_solver%solve_many(forces(i)%values, columns(:, n + 1:), ierr))
        PetscCall(take_residuals(team, columns, data%modes(i), ierr))
        deallocate (driven, columns)
      end do
      PetscCall(linear_solver%destroy(ierr))
      allocate (data%middle_compliance(0, 0))
      if (data%has_bound()) return
      PetscCall(close_rows(system, responses%contact, data%middle_compliance, ierr))
      call close_anchors(responses%anchors, data%middle_compliance)
      PetscCall(broadcast_columns(data%middle_compliance, PETSC_COMM_WORLD, ierr))
    end associate
  end subroutine measure_modes

  !> Sets the columns to zero outside of a body. Local.
  subroutine keep_body(team, dofs, columns)
    type(team_t), intent(in) :: team
    !> dofs of the body, natural
    integer, intent(in) :: dofs(:)
    !> rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), intent(inout) :: columns(:, :)
    logical :: is_own(team%solver%system%map%n_dofs)
    integer :: i

    is_own = .false.
    is_own(dofs) = .true.
    do i = 1, size(columns, 1)
      if (.not. is_own(team%solver%system%map%local_dofs(i))) columns(i, :) = 0
    end do
  end subroutine keep_body

  !> Sets modes%loads to Phi'F, the work of the loads on the modes Phi, which are the last columns of the basis V. Sets
  !> modes%contact to V'B', the work of unit contact forces on V after the motions that close the anchors. Collective on all ranks.
  subroutine take_work(team, anchors, basis, driven, modes, ierr)
    type(team_t), intent(in) :: team
    type(anchors_t), intent(in) :: anchors
    !> V of the body, rows of this rank
    real(rk), intent(in) :: basis(:, :)
    !> [force] K times the responses to loads
    real(rk), contiguous, intent(in) :: driven(:, :)
    type(body_modes_t), intent(inout) :: modes
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: closing(:, :), own(:, :)

    own = basis(:, size(modes%lifted_terms) + 1:)
    modes%loads = transposed_product(own, driven)
    PetscCall(sum_over_ranks(team%solver%system%comm, modes%loads, ierr))
    PetscCall(broadcast_columns(modes%loads, PETSC_COMM_WORLD, ierr))
    PetscCall(close_rows(team%solver%system, basis, closing, ierr))
    call close_anchors(anchors, closing)
    PetscCall(broadcast_columns(closing, PETSC_COMM_WORLD, ierr))
    modes%contact = transpose(closing)
  end subroutine take_work

  !> Sets modes%residuals to the triangle of find_triangle without its rows of zeros. Collective on all ranks.
  subroutine take_residuals(team, columns, modes, ierr)
    type(team_t), intent(inout) :: team
    !> [length] responses to loads and unit contact forces, then K^-1 times the forces of measure_parts; rows of this rank
    real(rk), contiguous, intent(in) :: columns(:, :)
    type(body_modes_t), intent(inout) :: modes
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: triangle(:, :)
    integer :: i

    PetscCall(find_triangle(team%solver%system%comm, team%solver%system%stiffness, columns, triangle, ierr))
    PetscCall(broadcast_columns(triangle, PETSC_COMM_WORLD, ierr))
    modes%residuals = triangle(pack([(i, i=1, size(triangle, 1))], any(abs(triangle) > 0, dim=2)), :)
  end subroutine take_residuals
end module sig_displacement_modes
