! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Computes the responses of bodies at the interpolation nodes, which are chosen values of their elastic constants. One
!> factorization of the whole stiffness gives the responses at one node of each body.
module sig_body_nodes
  use sig_body_constants, only: body_constants_t, joined_body_t
  use sig_condensed_training, only: share_rows
  use sig_contact_responses, only: close_rows, measure_work, solve_responses
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_full_order, only: team_t
  use sig_holding, only: anchors_t
  use sig_body_data, only: body_data_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: broadcast_columns
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use petsc
  implicit none(type, external)
  private
  public :: close_anchors, dofs_of_body, fill_nodes, grow_nodes, responses_t, solve_node, start_body

  !> The responses that one factorization gives; the rows of this rank.
  type :: responses_t
    type(anchors_t) :: anchors
    !> [length] displacements under loads, and under prescribed displacements, per term; shape (n_local_dofs, n_driving_terms)
    real(rk), allocatable :: loaded(:, :)
    real(rk), allocatable :: prescribed(:, :)
    !> [length/force] minus the displacements under a unit force on each contact row, shape (n_local_dofs, n_multipliers)
    real(rk), allocatable :: contact(:, :)
  end type responses_t

contains

  !> Starts data%bodies(i_body), a body that has no interpolation nodes yet. Local.
  subroutine start_body(problem, constants, i_body, data)
    type(problem_t), intent(in) :: problem
    !> of this body
    type(body_constants_t), intent(in) :: constants
    integer, intent(in) :: i_body
    !> exact_dofs must be set, and bodies allocated
    class(body_data_t), intent(inout) :: data
    logical, allocatable :: is_own(:)
    integer :: i

    is_own = dofs_of_body(problem, i_body)
    associate (body => data%bodies(i_body), n => problem%force_rows%n_rows, n_driving => problem%boundary%n_driving_terms)
      body%modulus_term = constants%modulus_term
      body%modulus = constants%moduli(1)
      body%numerators = constants%numerators
      body%denominators = constants%denominators
      body%is_logarithmic = constants%is_logarithmic
      body%is_thin = problem%body%mechanics%is_thin
      allocate (body%bound%residuals(0, 0), body%bound%rest(0, 0), body%bound%forces(0, 0))
      body%own = pack([(i, i=1, size(data%exact_dofs))], is_own(data%exact_dofs))
      allocate (body%compliance(n**2, 0), body%loaded_opening(n * n_driving, 0), body%prescribed_opening(n * n_driving, 0))
      allocate (body%loaded_energy(n_driving**2, 0), body%prescribed_energy(n_driving**2, 0))
      associate (n_own => size(body%own))
        allocate (body%loaded_field(n_own * n_driving, 0), body%prescribed_field(n_own * n_driving, 0))
        allocate (body%contact_field(n_own * n, 0))
      end associate
    end associate
  end subroutine start_body

  !> Whether each dof belongs to a body, in natural order; shape (n_dofs).
  pure function dofs_of_body(problem, i_body) result(is_own)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_body
    logical, allocatable :: is_own(:)

    associate (n_dim => problem%mesh%n_dim)
      is_own = reshape(spread(problem%motions%body_of_node == i_body, 1, n_dim), [n_dim * problem%mesh%n_nodes])
    end associate
  end function dofs_of_body

  !> Gives each body the interpolation nodes of the polynomial degree of a round, without responses for new ones. Nodes of earlier
  !> rounds stay the first ones.
  subroutine grow_nodes(constants, i_round, data)
    type(body_constants_t), intent(in) :: constants(:)
    !> number of the round, from 0 on
    integer, intent(in) :: i_round
    class(body_data_t), intent(inout) :: data
    integer :: i

    do i = 1, size(constants)
      call data%bodies(i)%nodes%create(constants(i)%lower, constants(i)%upper, constants(i)%degree(i_round))
    end do
  end subroutine grow_nodes

  !> Computes data%bodies(:), the responses of each body, at all of its interpolation nodes that have none yet. Changes `joined` and
  !> the stiffness of the team. Collective on all ranks, with the same result on each.
  !>
  !> Errors: the stiffness could not be factored.
  subroutine fill_nodes(problem, team, joined, data, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(inout) :: joined
    class(body_data_t), intent(inout) :: data
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(responses_t) :: responses
    logical :: is_pending(size(joined%constants))
    integer :: i

    ierr = 0
    do
      do i = 1, size(joined%constants)
        associate (body => data%bodies(i), next => size(data%bodies(i)%compliance, 2) + 1)
          is_pending(i) = next <= body%nodes%n_nodes()
          if (is_pending(i)) call joined%set(problem, i, body%nodes%node(next))
        end associate
      end do
      if (.not. any(is_pending)) return
      PetscCall(solve_node(problem, team, joined, data, responses, error, ierr))
      if (allocated(error)) return
      do i = 1, size(joined%constants)
        if (.not. is_pending(i)) cycle
        PetscCall(add_node(problem, team, responses, i, data, ierr))
      end do
    end do
  end subroutine fill_nodes

  !> Computes the responses for the elastic constants in `joined` with one factorization, and adds 1 to data%n_factorizations. The
  !> stiffness of the team is then that of `joined`. Collective on the ranks of the team.
  !>
  !> Errors: the stiffness could not be factored.
  subroutine solve_node(problem, team, joined, data, responses, error, ierr, forces)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(in) :: joined
    class(body_data_t), intent(inout) :: data
    type(responses_t), intent(out) :: responses
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> [force] sets of contact forces, shape (n_multipliers, n_sets); responses%contact are then minus the
    !> displacements [length] under these. Default: a unit force on each contact row
    real(rk), allocatable, intent(in), optional :: forces(:, :)
    real(rk), allocatable :: lifting(:, :)
    integer :: reason

    PetscCall(team%solver%take_body(problem, joined%body, ierr))
    associate (system => team%solver%system)
      PetscCall(solve_responses(system, responses%anchors, responses%loaded, lifting, responses%contact, reason, ierr, forces))
    end associate
    data%n_factorizations = data%n_factorizations + 1
    if (reason /= reason_converged) then
      call make_error(error, 'the stiffness could not be factored', problem%deck%path, exit_code=exit_not_converged)
      return
    end if
    allocate (responses%prescribed, mold=responses%loaded)
    responses%prescribed = 0
    associate (n_prescribed => size(problem%boundary%prescribed_values, 2))
      responses%prescribed(:, :n_prescribed) = lifting(:, :n_prescribed)
    end associate
    responses%loaded = responses%loaded - responses%prescribed
  end subroutine solve_node

  !> Appends to data%bodies(i_body) the part of the responses that belongs to this body, as those of its next node, with the values
  !> of the first rank. The stiffness of the team does not change. Requires: `responses` are those of solve_node with the constants
  !> of this node. Collective on all ranks.
  subroutine add_node(problem, team, responses, i_body, data, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(responses_t), intent(in) :: responses
    integer, intent(in) :: i_body
    class(body_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: values(:, :)
    logical, allocatable :: is_own(:)

    is_own = dofs_of_body(problem, i_body)
    associate (body => data%bodies(i_body), system => team%solver%system, anchors => responses%anchors)
      PetscCall(close_rows(system, responses%contact, values, ierr, is_own))
      call close_anchors(anchors, values)
      if (size(anchors%rows) == 0) values = (values + transpose(values)) / 2
      PetscCall(append(values, body%compliance, ierr))
      call set_scale(anchors, values, data)
      PetscCall(close_rows(system, responses%loaded, values, ierr, is_own))
      call close_anchors(anchors, values)
      PetscCall(append(-values, body%loaded_opening, ierr))
      PetscCall(close_rows(system, responses%prescribed, values, ierr, is_own))
      call close_anchors(anchors, values)
      PetscCall(append(-values, body%prescribed_opening, ierr))
      PetscCall(measure_work(system, responses%loaded, values, ierr, is_own))
      PetscCall(append(values, body%loaded_energy, ierr))
      PetscCall(measure_work(system, responses%prescribed, values, ierr, is_own))
      PetscCall(append(values, body%prescribed_energy, ierr))
      associate (dofs => data%exact_dofs(body%own))
        PetscCall(share_rows(team, responses%loaded, size(responses%loaded, 2), dofs, values, ierr))
        PetscCall(append(values, body%loaded_field, ierr))
        PetscCall(share_rows(team, responses%prescribed, size(responses%prescribed, 2), dofs, values, ierr))
        PetscCall(append(values, body%prescribed_field, ierr))
        PetscCall(share_rows(team, responses%contact, size(responses%contact, 2), dofs, values, ierr))
        PetscCall(append(values, body%contact_field, ierr))
      end associate
    end associate
  end subroutine add_node

  !> Changes the values of all contact rows (gaps or B u) to those after the rigid motions that close the anchors. The rows of the
  !> anchors are left as they are.
  pure subroutine close_anchors(anchors, values)
    type(anchors_t), intent(in) :: anchors
    !> [length or length/force] shape (n_multipliers, n_columns)
    real(rk), intent(inout) :: values(:, :)
    real(rk) :: own(size(anchors%rows), size(values, 2))

    own = values(anchors%rows, :)
    values = values - matmul(anchors%closing, own)
    values(anchors%rows, :) = own
  end subroutine close_anchors

  !> Sets data%scale, the scale of the unknowns of the anchors, to the mean size of the diagonal entries of a body's compliance, if
  !> this is above 0. Only the first factorization counts, which gives the first node of each body; of several bodies the last one
  !> with a mean above 0 counts. Does nothing without anchors.
  pure subroutine set_scale(anchors, compliance, data)
    type(anchors_t), intent(in) :: anchors
    !> [length/force] shape (n_multipliers, n_multipliers)
    real(rk), intent(in) :: compliance(:, :)
    class(body_data_t), intent(inout) :: data
    integer :: i
    real(rk) :: mean

    if (size(anchors%rows) == 0 .or. data%n_factorizations > 1) return
    mean = sum([(abs(compliance(i, i)), i=1, size(compliance, 1))]) / size(compliance, 1)
    if (mean > 0) data%scale = mean
  end subroutine set_scale

  !> Appends the values of the first rank, column by column, as one more column, the same on every rank. Collective on all ranks.
  subroutine append(values, columns, ierr)
    !> those of the first rank count
    real(rk), intent(in) :: values(:, :)
    !> shape (size(values), n_columns)
    real(rk), allocatable, intent(inout) :: columns(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: more(:, :)
    integer :: n

    n = size(columns, 2)
    allocate (more(size(columns, 1), n + 1))
    more(:, :n) = columns
    more(:, n + 1) = reshape(values, [size(values)])
    PetscCall(broadcast_columns(more(:, n + 1:), PETSC_COMM_WORLD, ierr))
    call move_alloc(more, columns)
  end subroutine append
end module sig_body_nodes
