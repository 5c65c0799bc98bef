! SPDX-License-Identifier: BSD-3-Clause
!> The linear problem of a step (sig_friction_unknowns) from the factors of an earlier one, of this time or of one before.
!>
!> From step to step few contacts change their state, and directions turn a little: P^-1 J is near the unit matrix, where J is the
!> matrix of this step and P the one that was factored last. So the change of the unknowns is sought by GMRES (Saad and Schultz
!> 1986) with P, from what the last step left, in few iterations of n m + m^2 operations for m unknowns and n rows, in place of m^3
!> / 3. Unknowns that P does not have are divided by their diagonal entry of J. As soon as iterations have cost as much as factors
!> would, J is factored, and is the next P: so a step costs at most twice what it does with the better choice. J has the unknowns of
!> W or of its inverse A, whichever are fewer at that moment.
!>
!> P is a function of the numbers that `kept_factors_t` remembers, and is computed from them in one way. So a history has the same
!> bits where its state was saved and restored, and what a room answered before changes none.
module sig_friction_kept
  use sig_dense_kernels, only: add_few_columns, factor_lu, multiply, reciprocal_condition_lu, solve_lu
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_unknown_t, &
    friction_workspace_t, most_searched
  use sig_friction_unknowns, only: assemble, count_unknowns, fill_independent, list_unknowns, start_unknowns, sum_equations
  use sig_kinds, only: rk
  use sig_lcp_types, only: measure_pivots, trusted_pivots
  use sig_linear_algebra, only: singular_reciprocal
  implicit none(type, external)
  private
  public :: solve_anew, solve_kept, remove_rounding

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
    call factor(matrix, n, workspace, is_singular)
    workspace%kept%is_factored = .false.
    if (is_singular) return
    lambda = 0
    call sum_equations(workspace%unknowns(:n), workspace%free, lambda, workspace%x)
    workspace%x(:n) = -workspace%x(:n)
    if (n > 0) call solve_lu(n, workspace%factors, workspace%pivots, workspace%x)
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
    integer :: n, n_inverse
    logical :: is_done, is_inverse

    is_singular = .false.
    is_done = .false.
    associate (kept => workspace%kept, states => workspace%states(:contacts%n_contacts))
      n = count_unknowns(.false., contacts, states)
      n_inverse = count_unknowns(.true., contacts, states)
      is_inverse = n_inverse < n
      left = cost_of_factors(min(n, n_inverse)) - kept%spent
      if (kept%is_inverse) n = n_inverse
      cost = cost_of_iteration(n, size(lambda))
      if (kept%is_set .and. left >= cost) call solve_by(int(min(left / cost, real(most_searched, rk))))
      if (is_done .or. is_singular) return
      call remember(friction, is_inverse, contacts, workspace)
      call solve_by(most_searched)
      ! what a step does with its own factors does not speak against them
      kept%spent = 0
    end associate

  contains

    subroutine solve_by(n_most)
      integer, intent(in) :: n_most

      if (workspace%kept%is_inverse) then
        call improve(inverse, friction, contacts, share, n_most, lambda, workspace, is_done, is_singular)
      else
        call improve(matrix, friction, contacts, share, n_most, lambda, workspace, is_done, is_singular)
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
  subroutine improve(square, friction, contacts, share, n_most, lambda, workspace, is_done, is_singular)
    !> W or its inverse
    real(rk), contiguous, intent(in) :: square(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    real(rk), intent(in) :: share
    !> iterations
    integer, intent(in) :: n_most
    real(rk), contiguous, intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    !> whether they suffice
    logical, intent(out) :: is_done
    logical, intent(out) :: is_singular
    integer :: n

    is_singular = .false.
    is_done = .false.
    if (.not. workspace%kept%is_factored) call restore_factors(square, contacts, workspace, is_singular)
    if (is_singular) return
    call list(workspace%kept%is_inverse, friction, contacts, workspace, n)
    associate (kept => workspace%kept, n_rows => size(lambda), unknowns => workspace%unknowns(:n), x => workspace%x(:n))
      associate (y => kept%y(:n_rows), z => kept%z(:n_rows), change => kept%basis(:n_rows, 1))
        y = merge(lambda, workspace%w(:n_rows), kept%is_inverse)
        z = merge(workspace%w(:n_rows), lambda, kept%is_inverse)
        call start_unknowns(unknowns, z, x)
        call fill_independent(unknowns, x, change)
        change = change - z
        call add_few_columns(square, change, y)
        z = z + change
        is_done = n == 0
        if (n > 0) call search(square, share, n_most, unknowns, x, workspace, is_done)
        lambda = merge(y, z, kept%is_inverse)
        workspace%w(:n_rows) = merge(z, y, kept%is_inverse)
      end associate
    end associate
  end subroutine improve

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
        workspace%unknowns, n)
      call factor(square, n, workspace, is_singular)
      kept%is_set = .not. is_singular
      kept%is_factored = .not. is_singular
      kept%n = n
      kept%places(:size(square, 1)) = 0
      do j = 1, n
        kept%places(workspace%unknowns(j)%home) = j
      end do
    end associate
  end subroutine restore_factors

  !> Factors the matrix of the unknowns, and finds whether it is numerically singular.
  subroutine factor(square, n, workspace, is_singular)
    real(rk), contiguous, intent(in) :: square(:, :)
    integer, intent(in) :: n
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    real(rk) :: norm, ratio
    integer :: info

    is_singular = .false.
    if (n == 0) return
    call assemble(square, workspace%unknowns(:n), workspace%factors, norm)
    call factor_lu(n, workspace%factors, workspace%pivots, info)
    workspace%kept%n_operations = workspace%kept%n_operations + cost_of_factors(n)
    call measure_pivots(workspace%factors, n, ratio)
    is_singular = info /= 0 .or. .not. ratio > 0
    if (is_singular .or. ratio >= trusted_pivots) return
    is_singular = .not. reciprocal_condition_lu(n, workspace%factors, norm, workspace%work, workspace%signs) > singular_reciprocal
  end subroutine factor

  !> Improves the unknowns by GMRES with the kept factors: changes y and z.
  subroutine search(square, share, n_most, unknowns, x, workspace, is_done)
    real(rk), contiguous, intent(in) :: square(:, :)
    real(rk), intent(in) :: share
    integer, intent(in) :: n_most
    type(friction_unknown_t), intent(in) :: unknowns(:)
    !> the start, shape (n)
    real(rk), contiguous, intent(inout) :: x(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done
    real(rk) :: bottom(size(unknowns)), left(size(unknowns)), moved(size(square, 1))
    real(rk) :: h(n_most + 1, n_most), rest(n_most + 1), turn(2, n_most)
    real(rk) :: goal
    integer :: i, j

    associate (kept => workspace%kept, n => size(unknowns), n_rows => size(square, 1))
      associate (y => kept%y(:n_rows), z => kept%z(:n_rows), basis => kept%basis, images => kept%images)
        call find_diagonal(square, unknowns, bottom)
        call sum_equations(unknowns, y, z, left)
        left = -left
        call divide(unknowns, bottom, workspace, left)
        rest(1) = norm2(left)
        goal = max(share * rest(1), 2 * epsilon(goal) * (norm2(x) + rest(1)))
        is_done = rest(1) <= goal
        if (is_done .or. .not. rest(1) <= huge(goal)) return
        basis(:n, 1) = left / rest(1)
        do j = 1, n_most
          call fill_independent(unknowns, basis(:n, j), moved)
          images(:n_rows, j) = 0
          call add_few_columns(square, moved, images(:n_rows, j))
          call sum_equations(unknowns, images(:n_rows, j), moved, left)
          call divide(unknowns, bottom, workspace, left)
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
        kept%n_operations = kept%n_operations + (j + 1) * cost_of_iteration(n, n_rows)
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

  !> Computes the diagonal entries of the matrix of the unknowns.
  pure subroutine find_diagonal(square, unknowns, diagonal)
    real(rk), intent(in) :: square(:, :)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    real(rk), intent(out) :: diagonal(:)
    integer :: m, j

    do j = 1, size(unknowns)
      associate (one => unknowns(j))
        m = one%n_rows
        diagonal(j) = dot_product(one%of_y(:m), matmul(square(one%rows(:m), one%rows(:m)), one%moves(:m))) + &
          dot_product(one%of_z, one%moves)
      end associate
      if (.not. abs(diagonal(j)) > 0) diagonal(j) = 1
    end do
  end subroutine find_diagonal

  !> Computes P^-1 times a vector.
  subroutine divide(unknowns, diagonal, workspace, vector)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    real(rk), intent(in) :: diagonal(:)
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk), intent(inout) :: vector(:)
    integer :: j

    associate (kept => workspace%kept, work => workspace%work)
      work(:kept%n) = 0
      do j = 1, size(unknowns)
        associate (place => kept%places(unknowns(j)%home))
          if (place > 0) then
            work(place) = vector(j)
          else
            vector(j) = vector(j) / diagonal(j)
          end if
        end associate
      end do
      if (kept%n > 0) call solve_lu(kept%n, workspace%factors, workspace%pivots, work)
      do j = 1, size(unknowns)
        associate (place => kept%places(unknowns(j)%home))
          if (place > 0) vector(j) = work(place)
        end associate
      end do
    end associate
  end subroutine divide

  !> Makes forces that were computed from openings meet the laws of contacts that do not stick exactly, where they do so up to
  !> rounding. Their openings stay.
  pure subroutine remove_rounding(states, friction, contacts, lambda)
    integer, intent(in) :: states(:)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: lambda(:)
    real(rk) :: force
    integer :: k

    do k = 1, contacts%n_contacts
      if (states(k) == contact_sticks) cycle
      associate (rows => contacts%tangents(:contacts%n_tangents(k), k))
        if (states(k) == contact_open) lambda(k) = 0
        force = norm2(lambda(rows))
        if (force > 0) lambda(rows) = lambda(rows) * (friction(k) * lambda(k) / force)
      end associate
    end do
  end subroutine remove_rounding
end module sig_friction_kept
