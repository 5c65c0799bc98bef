! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Computes the residuals of responses that are interpolated over one elastic constant of each body. sig_interpolation_bound bounds
!> the error of answers by them.
!>
!> The stiffness is factored again at all nodes, so that only the responses at one node are in memory at a time. Notation, for one
!> body: U is its response at a chosen value ("place") of its constant, U_I the interpolated one, E = U - U_I; K_0 and W_0 are its
!> stiffness and its compliance at this value.
module sig_interpolation_residuals
  use sig_body_constants, only: body_constants_t, joined_body_t
  use sig_body_nodes, only: close_anchors, dofs_of_body, responses_t, solve_node
  use sig_contact_responses, only: close_rows
  use sig_dense_kernels, only: factor_cholesky, reduce_cholesky
  use sig_errors, only: error_t
  use sig_full_order, only: team_t
  use sig_holding, only: anchors_t
  use sig_body_data, only: body_data_t
  use sig_interpolation_bound, only: interpolation_bound_t, node_product, stiffness_factor
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product
  use sig_petsc_support, only: broadcast_columns, multiply_block, sum_over_ranks
  use sig_problem, only: problem_t
  use sig_rounding, only: rounding
  use sig_singular_values, only: svd
  use petsc
  implicit none(type, external)
  private
  public :: may_have_bounds, measure_residuals

  !> number of places from which widest_place chooses
  integer, parameter :: n_places = 101

contains

  !> Sets data%bodies(:)%bound of each body with one variable elastic constant of which its stiffness is a factor times an affine
  !> function (has_identity). Without such a body nothing changes. Otherwise the stiffness of the team and the constants in `joined`
  !> end at other values. Collective on all ranks, with the same result on each.
  !>
  !> Errors: the stiffness could not be factored.
  subroutine measure_residuals(problem, team, joined, data, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(inout) :: joined
    class(body_data_t), intent(inout) :: data
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(anchors_t) :: anchors
    real(rk), allocatable :: missing(:, :), columns(:, :)
    real(rk) :: places(size(joined%constants))
    integer :: i_body, i_node, n_nodes

    ierr = 0
    if (.not. any([(has_identity(joined%constants(i_body)), i_body=1, size(joined%constants))])) return
    n_nodes = 0
    do i_body = 1, size(joined%constants)
      if (.not. has_identity(joined%constants(i_body))) cycle
      places(i_body) = widest_place(data, i_body)
      n_nodes = max(n_nodes, data%bodies(i_body)%nodes%n_nodes())
    end do
    ! the responses at the places come last, so that the stiffness is then that of the places
    do i_node = 1, n_nodes + 1
      PetscCall(solve_at(problem, team, joined, places, i_node, n_nodes, data, columns, anchors, error, ierr))
      if (allocated(error)) return
      if (.not. allocated(missing)) allocate (missing(size(columns, 1), size(columns, 2)), source=0.0_rk)
      call add_weighted(problem, team, joined%constants, places, i_node, n_nodes, data, columns, missing)
    end do
    PetscCall(fill_bounds(problem, team, joined%constants, places, missing, columns, anchors, data, ierr))
  end subroutine measure_residuals

  !> Whether each body is exact, or measure_residuals sets its bound.
  pure logical function may_have_bounds(constants)
    type(body_constants_t), intent(in) :: constants(:)
    integer :: i

    may_have_bounds = all([(size(constants(i)%numerators) == 0 .or. has_identity(constants(i)), i=1, size(constants))])
  end function may_have_bounds

  !> Whether the body has exactly one variable elastic constant, its stiffness is a factor times an affine function of it, and the
  !> responses are interpolated over the constant itself, not over its logarithm. False for Poisson's ratio of a body with several
  !> materials.
  pure logical function has_identity(constants)
    type(body_constants_t), intent(in) :: constants

    has_identity = .false.
    if (size(constants%numerators) /= 1 .or. constants%is_logarithmic) return
    has_identity = constants%denominators(1) > 0 .or. size(constants%materials) == 1
  end function has_identity

  !> Returns the value of the elastic constant, of 101 in the middle third of its range, where the product of the distances from the
  !> interpolation nodes is largest. Requires: has_identity.
  pure real(rk) function widest_place(data, i_body) result(widest)
    class(body_data_t), intent(in) :: data
    integer, intent(in) :: i_body
    real(rk) :: distance, largest, place
    integer :: i

    largest = -1
    widest = 0
    associate (nodes => data%bodies(i_body)%nodes)
      do i = 1, n_places
        place = nodes%lower(1) + (nodes%upper(1) - nodes%lower(1)) * (1 + real(i - 1, rk) / (n_places - 1)) / 3
        distance = abs(node_product(nodes%on_line(), place))
        if (distance <= largest) cycle
        largest = distance
        widest = place
      end do
    end associate
  end function widest_place

  !> Computes the responses to loads, prescribed displacements and contact forces, in this order. The constants of each body with
  !> has_identity are those of its node i_node, or those of `places` where i_node is larger than n_nodes. A body that has no node
  !> i_node, and all other bodies, keep the constants in `joined`. Changes `joined` and the stiffness of the team. Collective on the
  !> ranks of the team. Errors: the stiffness could not be factored.
  subroutine solve_at(problem, team, joined, places, i_node, n_nodes, data, columns, anchors, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(inout) :: joined
    !> value of the variable of each body with has_identity
    real(rk), intent(in) :: places(:)
    !> 1-based; larger than n_nodes: the places
    integer, intent(in) :: i_node
    !> largest number of nodes of these bodies
    integer, intent(in) :: n_nodes
    class(body_data_t), intent(inout) :: data
    !> [length; for contact forces length/force] rows of this rank, shape (n_local_dofs, 2 * n_driving_terms + n_multipliers)
    real(rk), allocatable, intent(out) :: columns(:, :)
    !> those of the bodies that only contact holds
    type(anchors_t), intent(out) :: anchors
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(responses_t) :: responses
    integer :: i

    do i = 1, size(joined%constants)
      if (.not. has_identity(joined%constants(i))) cycle
      if (i_node > n_nodes) then
        call joined%set(problem, i, [places(i)])
      else if (i_node <= data%bodies(i)%nodes%n_nodes()) then
        call joined%set(problem, i, data%bodies(i)%nodes%node(i_node))
      end if
    end do
    PetscCall(solve_node(problem, team, joined, data, responses, error, ierr))
    if (allocated(error)) return
    anchors = responses%anchors
    associate (n_driving => size(responses%loaded, 2))
      allocate (columns(size(responses%loaded, 1), 2 * n_driving + size(responses%contact, 2)))
      columns(:, :n_driving) = responses%loaded
      columns(:, n_driving + 1:2 * n_driving) = responses%prescribed
      columns(:, 2 * n_driving + 1:) = responses%contact
    end associate
  end subroutine solve_at

  !> Adds the responses at node i_node, times minus the weight of this node in the interpolation at the body's place, to E = U - U_I
  !> on the dofs of the bodies with has_identity; or, where i_node is larger than n_nodes, the responses at the places, times 1. A
  !> body that has no node i_node gets nothing. Local.
  subroutine add_weighted(problem, team, constants, places, i_node, n_nodes, data, columns, missing)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(in) :: team
    type(body_constants_t), intent(in) :: constants(:)
    !> as in solve_at
    real(rk), intent(in) :: places(:)
    !> i_node and n_nodes as in solve_at; `columns` are the responses there
    integer, intent(in) :: i_node
    integer, intent(in) :: n_nodes
    class(body_data_t), intent(in) :: data
    !> [length] of solve_at
    real(rk), intent(in) :: columns(:, :)
    !> [length] E, same shape
    real(rk), intent(inout) :: missing(:, :)
    real(rk), allocatable :: weights(:)
    real(rk) :: factor(size(missing, 1))
    logical, allocatable :: is_own(:)
    integer :: i

    factor = 0
    do i = 1, size(constants)
      if (.not. has_identity(constants(i))) cycle
      is_own = dofs_of_body(problem, i)
      allocate (weights(max(i_node, data%bodies(i)%nodes%n_nodes())), source=0.0_rk)
      call data%bodies(i)%nodes%weights([places(i)], weights(:data%bodies(i)%nodes%n_nodes()))
      where (is_own(team%solver%system%map%local_dofs)) factor = merge(1.0_rk, -weights(i_node), i_node > n_nodes)
      deallocate (weights)
    end do
    do i = 1, size(missing, 2)
      missing(:, i) = missing(:, i) + factor * columns(:, i)
    end do
  end subroutine add_weighted

  !> Fills data%bodies(:)%bound of each body with has_identity: its stiffness is a factor times an affine function of one elastic
  !> constant, and its responses are interpolated over this constant, not over its logarithm. Requires: the stiffness of the team is
  !> that of the places. Collective on all ranks.
  subroutine fill_bounds(problem, team, constants, places, missing, columns, anchors, data, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(body_constants_t), intent(in) :: constants(:)
    !> as in solve_at
    real(rk), intent(in) :: places(:)
    !> [length] E = U - U_I, responses minus interpolated ones at the places; rows of this rank, columns as in solve_at
    real(rk), intent(in) :: missing(:, :)
    !> [length] the responses U at the places, same shape
    real(rk), intent(in) :: columns(:, :)
    type(anchors_t), intent(in) :: anchors
    class(body_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: forces(:, :), own(:, :), openings(:, :), compliance(:, :), others(:, :)
    logical, allocatable :: is_own(:)
    real(rk) :: factor, share(1, 1)
    integer :: i

    ierr = 0
    allocate (forces, mold=missing)
    associate (system => team%solver%system, n_coefficients => size(missing, 2))
      PetscCall(multiply_block(system%stiffness, missing, forces, ierr))
      do i = 1, size(constants)
        if (.not. has_identity(constants(i))) cycle
        is_own = dofs_of_body(problem, i)
        own = missing
        own(pack_false(is_own(system%map%local_dofs)), :) = 0
        factor = stiffness_factor(places(i), constants(i)%denominators(1) > 0, data%bodies(i)%is_thin) / &
          node_product(data%bodies(i)%nodes%on_line(), places(i))
        associate (bound => data%bodies(i)%bound)
          bound%place = places(i)
          bound%residuals = factor**2 * transposed_product(own, forces)
          PetscCall(sum_over_ranks(system%comm, bound%residuals, ierr))
          PetscCall(close_rows(system, missing, openings, ierr, is_own))
          PetscCall(close_rows(system, columns(:, n_coefficients - problem%force_rows%n_rows + 1:), compliance, ierr, is_own))
          PetscCall(close_rows(system, columns(:, n_coefficients - problem%force_rows%n_rows + 1:), others, ierr, .not. is_own))
          call close_anchors(anchors, openings)
          call close_anchors(anchors, compliance)
          call close_anchors(anchors, others)
          call split(anchors, factor * openings, compliance, bound)
          share = share_of_others(anchors, compliance, others)
          PetscCall(broadcast_columns(share, PETSC_COMM_WORLD, ierr))
          bound%share = share(1, 1)
          PetscCall(broadcast_columns(bound%residuals, PETSC_COMM_WORLD, ierr))
          PetscCall(broadcast_columns(bound%rest, PETSC_COMM_WORLD, ierr))
          PetscCall(broadcast_columns(bound%forces, PETSC_COMM_WORLD, ierr))
        end associate
      end do
    end associate
  end subroutine fill_bounds

  !> Sets bound%forces = W_0^+ g for the openings g, and bound%rest = bound%residuals - g'W_0^+ g. W_0 is taken without the rows of
  !> the anchors, where bound%forces are 0. Local.
  subroutine split(anchors, openings, compliance, bound)
    type(anchors_t), intent(in) :: anchors
    !> [length per unit of a coefficient] g: openings by the scaled E of fill_bounds, with anchors closed; shape (n_multipliers,
    !> n_coefficients)
    real(rk), intent(in) :: openings(:, :)
    !> [length/force] W_0, the compliance of the body with its elastic constant at bound%place
    real(rk), intent(in) :: compliance(:, :)
    !> its residuals must be set
    type(interpolation_bound_t), intent(inout) :: bound
    real(rk), allocatable :: u(:, :), s(:), vt(:, :), scaled(:, :)
    integer, allocatable :: free(:)
    integer :: i, n

    free = pack([(i, i=1, size(compliance, 1))], [(all(anchors%rows /= i), i=1, size(compliance, 1))])
    call svd(compliance(free, free), u, s, vt)
    n = count(s > rounding * maxval([0.0_rk, s]))
    scaled = matmul(transpose(u(:, :n)), openings(free, :))
    do i = 1, n
      scaled(i, :) = scaled(i, :) / sqrt(s(i))
    end do
    bound%rest = bound%residuals - transposed_product(scaled, scaled)
    do i = 1, n
      scaled(i, :) = scaled(i, :) / sqrt(s(i))
    end do
    if (allocated(bound%forces)) deallocate (bound%forces)
    allocate (bound%forces(size(openings, 1), size(openings, 2)), source=0.0_rk)
    bound%forces(free, :) = matmul(u(:, :n), scaled)
  end subroutine split

  !> [-] Returns a lower bound of the largest k for which W_others - k W_body is positive semidefinite, on the rows that are no
  !> anchors; 0 where W_others is singular, W_body is 0, or there are no such rows. Local.
  real(rk) function share_of_others(anchors, compliance, others) result(share)
    type(anchors_t), intent(in) :: anchors
    !> [length/force] compliance W_body of the body, and W_others of all other bodies
    real(rk), intent(in) :: compliance(:, :)
    real(rk), intent(in) :: others(:, :)
    real(rk), allocatable :: factor(:, :), own(:, :), u(:, :), s(:), vt(:, :)
    integer, allocatable :: free(:)
    integer :: i, info

    share = 0
    free = pack([(i, i=1, size(compliance, 1))], [(all(anchors%rows /= i), i=1, size(compliance, 1))])
    if (size(free) == 0) return
    own = (compliance(free, free) + transpose(compliance(free, free))) / 2
    factor = (others(free, free) + transpose(others(free, free))) / 2
    do i = 1, size(free)
      factor(i, i) = factor(i, i) - rounding * maxval(abs(others))
    end do
    call factor_cholesky(size(free), factor, info)
    if (info /= 0) return
    do i = 1, size(free)
      call reduce_cholesky(size(free), factor, own(:, i))
    end do
    own = transpose(own)
    do i = 1, size(free)
      call reduce_cholesky(size(free), factor, own(:, i))
    end do
    call svd(own, u, s, vt)
    if (s(1) > 0) share = 1 / s(1)
  end function share_of_others

  !> Returns the indices of the false flags, 1-based, ascending.
  pure function pack_false(flags) result(places)
    logical, intent(in) :: flags(:)
    integer, allocatable :: places(:)
    integer :: i

    places = pack([(i, i=1, size(flags))], .not. flags)
  end function pack_false
end module sig_interpolation_residuals
