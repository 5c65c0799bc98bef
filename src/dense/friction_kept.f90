! SPDX-License-Identifier: BSD-3-Clause
!> The linear problem of a step (sig_friction_unknowns) from the factors of an earlier one, of this time or of one before.
!>
!> From step to step few contacts change their state: their laws are exchanged (sig_friction_exchange), which costs m^2 operations
!> for each row whose law is another one since P, the matrix of m unknowns that was factored last, in place of m^3 / 3. Where
!> directions turn a little, or coefficients of friction change, this is near J^-1, where J is the matrix of this step: then GMRES
!> (Saad and Schultz 1986) seeks the change of the unknowns, from what the last step left, in few iterations of n m + m^2
!> operations for n rows. J is factored, and is the next P, where more than a quarter of the laws differ, or as soon as iterations
!> have cost as much as factors would. J has the unknowns of W or of its inverse A, whichever are fewer at that moment.
!>
!> P is a function of the numbers that `kept_factors_t` remembers, and is computed from them in one way. So a history has the same
!> bits where its state was saved and restored, and what a room answered before changes none.
module sig_friction_kept
  use sig_dense_kernels, only: add_few_columns, factor_lu, multiply, reciprocal_condition_lu, solve_lu, sum_of_sizes
  use sig_friction_exchange, only: choose_exchanged, divide, prepare_exchange
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_unknown_t, &
    friction_workspace_t, length, most_searched
  use sig_friction_unknowns, only: assemble, count_unknowns, fill_independent, list_unknowns, start_unknowns, sum_equations
  use sig_kinds, only: rk
  use sig_lcp_types, only: measure_pivots, trusted_pivots
  use sig_linear_algebra, only: singular_reciprocal
  implicit none(type, external)
  private
  public :: solve_anew, solve_kept, remove_rounding

  !> laws are exchanged in at most this part of the unknowns: solutions for more rows cost as much as factors
  integer, parameter :: exchanged_share = 4
  !> [-] of the unknowns: iterations seek no smaller change, which rounding would hide
  real(rk), parameter :: smallest_change = 1.0e-14_rk

contains

  !> Solves the problem of the states in the workspace for forces, with factors of its own. Kept factors are lost, but not what they
  !> are made from.
  subroutine solve_anew(matrix, friction, contacts, lambda, workspace, is_singular)
    !> W, shape (n_rows, n_rows)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    integer :: n

    call list(.false., friction, contacts, workspace, n)
    call factor(matrix, workspace%unknowns(:n), workspace, is_singular)
    workspace%kept%is_factored = .false.
    if (is_singular) return
    lambda = 0
    call sum_equations(workspace%unknowns(:n), workspace%free, lambda, workspace%x)
    workspace%x(:n) = -workspace%x(:n)
    if (n > 0) call solve_lu(n, workspace%factors, workspace%pivots, workspace%x)
    workspace%kept%n_operations = workspace%kept%n_operations + 2 * real(n, rk)**2
    call fill_independent(workspace%unknowns(:n), workspace%x(:n), lambda)
  end subroutine solve_anew

  !> Solves the same problem up to a share of the change, by kept factors or new ones.
  subroutine solve_kept(matrix, inverse, friction, contacts, share, lambda, workspace, is_singular)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> of W, same shape
    real(rk), contiguous, intent(in) :: inverse(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [-] 0: up to rounding
    real(rk), intent(in) :: share
    !> [force] in: any forces, with their openings in workspace%w
    real(rk), contiguous, intent(inout) :: lambda(:)
    !> w: out: the openings of lambda
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    real(rk) :: cost, left
    integer :: n, n_inverse, n_least
    logical :: is_done, is_inverse

    is_singular = .false.
    is_done = .false.
    associate (kept => workspace%kept, states => workspace%states(:contacts%n_contacts))
      n = count_unknowns(.false., contacts, states)
      n_inverse = count_unknowns(.true., contacts, states)
      is_inverse = n_inverse < n
      n_least = min(n, n_inverse)
      if (kept%is_set) then
        left = cost_of_factors(n_least) - kept%spent
        cost = cost_of_iteration(merge(n_inverse, n, kept%is_inverse), size(lambda))
        call solve_by(int(max(0.0_rk, min(left / max(cost, 1.0_rk), real(most_searched, rk)))), n_least / exchanged_share)
      end if
      if (is_done .or. is_singular) return
      call remember(friction, is_inverse, contacts, workspace)
      call solve_by(most_searched, 0)
      ! what a step does with its own factors does not speak against them
      kept%spent = 0
    end associate

  contains

    subroutine solve_by(n_most, n_most_exchanged)
      integer, intent(in) :: n_most, n_most_exchanged

      if (workspace%kept%is_inverse) then
        call improve(inverse, friction, contacts, share, n_most, n_most_exchanged, lambda, workspace, is_done, is_singular)
      else
        call improve(matrix, friction, contacts, share, n_most, n_most_exchanged, lambda, workspace, is_done, is_singular)
      end if
    end subroutine solve_by
  end subroutine solve_kept

  !> [-] Operations of the factors of n unknowns, and of an iteration with them.
  pure real(rk) function cost_of_factors(n) result(cost)
    integer, intent(in) :: n

    cost = 2 * real(n, rk)**3 / 3
  end function cost_of_factors

  pure real(rk) function cost_of_iteration(n, n_rows) result(cost)
    integer, intent(in) :: n, n_rows

    cost = 2 * real(n, rk) * (n_rows + n)
  end function cost_of_iteration

  !> Remembers the problem of the workspace as the one whose matrix is factored.
  pure subroutine remember(friction, is_inverse, contacts, workspace)
    real(rk), intent(in) :: friction(:)
    logical, intent(in) :: is_inverse
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace

    associate (kept => workspace%kept, n => contacts%n_contacts)
      kept%friction = friction
      kept%states = workspace%states(:n)
      kept%directions = workspace%directions(:, :n)
      kept%softness = workspace%softness(:n)
      where (kept%states /= contact_slips)
        kept%directions(1, :) = 0
        kept%directions(2, :) = 0
        kept%softness = 0
      end where
      kept%is_inverse = is_inverse
      kept%is_set = .true.
      kept%is_factored = .false.
      kept%spent = 0
    end associate
  end subroutine remember

  !> Changes the forces and openings to those of the states in the workspace, with the factors that are remembered.
  subroutine improve(square, friction, contacts, share, n_most, n_most_exchanged, lambda, workspace, is_done, is_singular)
    !> W or its inverse
    real(rk), contiguous, intent(in) :: square(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    real(rk), intent(in) :: share
    !> iterations, and rows whose laws may be exchanged
    integer, intent(in) :: n_most, n_most_exchanged
    real(rk), contiguous, intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    !> whether they suffice
    logical, intent(out) :: is_done
    logical, intent(out) :: is_singular
    integer :: n
    logical :: is_exact, is_usable

    is_singular = .false.
    is_done = .false.
    call choose_exchanged(friction, contacts, workspace, is_exact)
    if (workspace%kept%exchange%n > min(n_most_exchanged, size(workspace%kept%exchange%laws))) return
    if (.not. is_exact .and. n_most < 1) return
    if (.not. workspace%kept%is_factored) call restore_factors(square, contacts, workspace, is_singular)
    if (is_singular) return
    call list(workspace%kept%is_inverse, friction, contacts, workspace, n)
    call prepare_exchange(square, friction, contacts, workspace%unknowns(:n), workspace, is_usable)
    if (.not. is_usable) return
    associate (kept => workspace%kept, n_rows => size(lambda), unknowns => workspace%unknowns(:n))
      if (kept%is_inverse) then
        kept%y(:n_rows) = lambda
        kept%z(:n_rows) = workspace%w(:n_rows)
      else
        kept%y(:n_rows) = workspace%w(:n_rows)
        kept%z(:n_rows) = lambda
      end if
      call start_unknowns(unknowns, kept%z(:n_rows), workspace%x(:n))
      call move_to_unknowns(square, unknowns, workspace)
      is_done = n == 0
      if (n > 0 .and. is_exact) call solve_exactly(square, contacts, unknowns, workspace, is_done)
      if (n > 0 .and. .not. is_exact) call search(square, contacts, share, n_most, unknowns, workspace%x(:n), workspace, is_done)
      if (kept%is_inverse) then
        lambda = kept%y(:n_rows)
        workspace%w(:n_rows) = kept%z(:n_rows)
      else
        workspace%w(:n_rows) = kept%y(:n_rows)
        lambda = kept%z(:n_rows)
      end if
    end associate
  end subroutine improve

  !> Changes z to what the unknowns make of it, and y with it.
  subroutine move_to_unknowns(square, unknowns, workspace)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    type(friction_workspace_t), intent(inout) :: workspace

    associate (kept => workspace%kept, n_rows => size(square, 1))
      associate (change => kept%basis(:n_rows, 1))
        call fill_independent(unknowns, workspace%x(:size(unknowns)), change)
        change = change - kept%z(:n_rows)
        call add_few_columns(square, change, kept%y(:n_rows))
        kept%z(:n_rows) = kept%z(:n_rows) + change
      end associate
    end associate
  end subroutine move_to_unknowns

  !> Solves where the laws that differ from those of the factors are exchanged.
  subroutine solve_exactly(square, contacts, unknowns, workspace, is_done)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_unknown_t), intent(in) :: unknowns(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done
    real(rk) :: left(size(unknowns))

    associate (kept => workspace%kept, n_rows => size(square, 1))
      call sum_equations(unknowns, kept%y(:n_rows), kept%z(:n_rows), left)
      left = -left
      call divide(square, contacts, unknowns, workspace, left)
      is_done = sum_of_sizes(left) <= huge(left)
      if (.not. is_done) return
      workspace%x(:size(unknowns)) = workspace%x(:size(unknowns)) + left
      call move_to_unknowns(square, unknowns, workspace)
    end associate
  end subroutine solve_exactly

  !> Lists the unknowns of the states in the workspace.
  pure subroutine list(is_inverse, friction, contacts, workspace, n)
    logical, intent(in) :: is_inverse
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(out) :: n

    call list_unknowns(is_inverse, friction, contacts, workspace%states, workspace%directions, workspace%softness, workspace%c, &
      workspace%unknowns, n)
  end subroutine list

  !> Computes the factors that are remembered.
  subroutine restore_factors(square, contacts, workspace, is_singular)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    integer :: j, n

    associate (kept => workspace%kept)
      call list_unknowns(kept%is_inverse, kept%friction, contacts, kept%states, kept%directions, kept%softness, workspace%c, &
        kept%unknowns, n)
      call factor(square, kept%unknowns(:n), workspace, is_singular)
      kept%is_set = .not. is_singular
      kept%is_factored = .not. is_singular
      kept%n = n
      kept%places(:size(square, 1)) = 0
      do j = 1, n
        kept%places(kept%unknowns(j)%home) = j
      end do
      call kept%exchange%clear()
    end associate
  end subroutine restore_factors

  !> Factors the matrix of the unknowns, and finds whether it is numerically singular.
  subroutine factor(square, unknowns, workspace, is_singular)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    real(rk) :: norm, ratio
    integer :: info

    is_singular = .false.
    if (size(unknowns) == 0) return
    associate (n => size(unknowns))
      call assemble(square, unknowns, workspace%factors, norm)
      call factor_lu(n, workspace%factors, workspace%pivots, info)
      workspace%kept%n_operations = workspace%kept%n_operations + cost_of_factors(n)
      call measure_pivots(workspace%factors, n, ratio)
      is_singular = info /= 0 .or. .not. ratio > 0
      if (is_singular .or. ratio >= trusted_pivots) return
      is_singular = .not. reciprocal_condition_lu(n, workspace%factors, norm, workspace%work, workspace%signs) > &
        singular_reciprocal
    end associate
  end subroutine factor

  !> Improves the unknowns by GMRES with the kept factors: changes y and z.
  subroutine search(square, contacts, share, n_most, unknowns, x, workspace, is_done)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    real(rk), intent(in) :: share
    integer, intent(in) :: n_most
    type(friction_unknown_t), intent(in) :: unknowns(:)
    !> the start, shape (n)
    real(rk), contiguous, intent(inout) :: x(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done
    real(rk) :: left(size(unknowns)), moved(size(square, 1))
    real(rk) :: h(n_most + 1, n_most), rest(n_most + 1), turn(2, n_most)
    real(rk) :: goal
    integer :: i, j

    associate (kept => workspace%kept, n => size(unknowns), n_rows => size(square, 1))
      associate (y => kept%y(:n_rows), z => kept%z(:n_rows), basis => kept%basis, images => kept%images)
        call sum_equations(unknowns, y, z, left)
        left = -left
        call divide(square, contacts, unknowns, workspace, left)
        rest(1) = norm2(left)
        goal = max(share * rest(1), smallest_change * (norm2(x) + rest(1)))
        is_done = rest(1) <= goal
        if (is_done .or. .not. rest(1) <= huge(goal)) return
        basis(:n, 1) = left / rest(1)
        do j = 1, n_most
          call fill_independent(unknowns, basis(:n, j), moved)
          images(:n_rows, j) = 0
          call add_few_columns(square, moved, images(:n_rows, j))
          call sum_equations(unknowns, images(:n_rows, j), moved, left)
          call divide(square, contacts, unknowns, workspace, left)
          do i = 1, j
            h(i, j) = dot_product(basis(:n, i), left)
            left = left - h(i, j) * basis(:n, i)
          end do
          h(j + 1, j) = norm2(left)
          if (h(j + 1, j) > 0) basis(:n, j + 1) = left / h(j + 1, j)
          call turn_column(j, h(:, j), turn, rest)
          is_done = abs(rest(j + 1)) <= goal .or. .not. abs(h(j, j)) > 0
          if (is_done) exit
        end do
        j = min(j, n_most)
        kept%spent = kept%spent + j * cost_of_iteration(n, n_rows)
        kept%n_operations = kept%n_operations + j * (cost_of_iteration(n, n_rows) - 2 * real(n, rk)**2)
        do i = j, 1, -1
          rest(i) = (rest(i) - dot_product(h(i, i + 1:j), rest(i + 1:j))) / h(i, i)
        end do
        call multiply(1.0_rk, basis(:n, :j), rest(:j), 0.0_rk, left)
        call multiply(1.0_rk, images(:n_rows, :j), rest(:j), 1.0_rk, y)
        x = x + left
        call fill_independent(unknowns, x, z)
      end associate
    end associate
  end subroutine search

  !> Makes the Hessenberg matrix of GMRES a triangle, by rotations.
  pure subroutine turn_column(j, column, turn, rest)
    integer, intent(in) :: j
    real(rk), intent(inout) :: column(:)
    !> cosines and sines
    real(rk), intent(inout) :: turn(:, :)
    real(rk), intent(inout) :: rest(:)
    real(rk) :: upper
    integer :: i

    do i = 1, j
      if (i == j) turn(:, j) = column(j:j + 1) / max(norm2(column(j:j + 1)), tiny(upper))
      upper = column(i)
      column(i) = turn(1, i) * upper + turn(2, i) * column(i + 1)
      column(i + 1) = turn(1, i) * column(i + 1) - turn(2, i) * upper
    end do
    rest(j + 1) = -turn(2, j) * rest(j)
    rest(j) = turn(1, j) * rest(j)
  end subroutine turn_column

  !> Makes forces that were computed from openings meet the laws of contacts that do not stick exactly, where they do so up to
  !> rounding. Their openings stay.
  pure subroutine remove_rounding(states, friction, contacts, lambda)
    integer, intent(in) :: states(:)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: lambda(:)
    real(rk) :: force
    integer :: i, k

    do k = 1, contacts%n_contacts
      if (states(k) == contact_sticks) cycle
      if (states(k) == contact_open) lambda(k) = 0
      force = length(contacts%tangential(k, lambda))
      if (.not. force > 0) cycle
      do i = 1, contacts%n_tangents(k)
        associate (tangential => lambda(contacts%tangents(i, k)))
          tangential = tangential * (friction(k) * lambda(k) / force)
        end associate
      end do
    end do
  end subroutine remove_rounding
end module sig_friction_kept
