! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the answer of a step with Coulomb friction (sig_friction_problem) with respect to q, the origins of slip and the
!> coefficients of friction, in some directions. W stays the same.
!>
!> The forces of the closed contacts change so that their conditions hold on. With w' = W lambda' + q' and v' = w_t' + s_0':
!>
!>     closed: w_n' = 0;   sticks: v' = 0;   slips: lambda_t' = (f lambda_n)' d + lambda_e' e,  v_e' + k lambda_e' = 0
!>
!> where d is the direction of slip, e the one across it (in space), and k = |slip| / (f lambda_n), as the force follows the
!> direction of slip. Rows of motions have w' = 0.
!>
!> A contact may be at the border of two states, up to rounding (it grazes). Where it has neither a force nor a gap, and no
!> friction, 0 <= lambda_n', w_n' >= 0 with a zero product. Where its tangential force is the largest possible one without slip,
!>
!>     lambda_t' = (f lambda_n)' d + lambda_e' e - y d,  v_e' = 0,  slip' = x d,  0 <= x, y >= 0, x y = 0.
!>
!> These x and y are the solution of a small complementarity problem, and the derivative in the opposite direction is in general
!> not just the negative of this one. Where a contact with friction has neither a force nor a gap, there is a derivative in the
!> directions in which it does not close, as in those that change nothing; where one without friction gets friction and does not
!> slip, in the other directions.
module sig_friction_derivative
  use sig_dense_kernels, only: multiply
  use sig_friction_types, only: contact_open, friction_contacts_t, friction_solution_t
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, solve_lcp
  use sig_linear_algebra, only: lu_t
  use sig_rounding, only: rounding, rounding_of_data
  implicit none(type, external)
  private
  public :: friction_derivative_t, friction_step_t, differentiate_friction

  !> A solved step.
  type :: friction_step_t
    !> [length] q and s_0 as for solve_friction, and for each row the sum of the sizes of the terms of q, shape (n_rows)
    real(rk), allocatable :: q(:)
    real(rk), allocatable :: origins(:)
    real(rk), allocatable :: terms(:)
    !> [-] coefficient of friction of each contact, 0 without tangential rows and where it is tied; shape (n_contacts)
    real(rk), allocatable :: friction(:)
  end type friction_step_t

  !> The derivatives in each direction.
  type :: friction_derivative_t
    !> [force] lambda' and [length] w' + s_0' (s_0' in tangential rows), shape (n_rows, n_directions)
    real(rk), allocatable :: forces(:, :)
    real(rk), allocatable :: openings(:, :)
    !> whether the derivative in the opposite direction is not just the negative of this one, shape (n_directions)
    logical, allocatable :: is_one_sided(:)
    !> number of contacts at the border of two states
    integer :: n_grazing = 0
    !> directions without a derivative, because of a contact at a border; shape (n_directions)
    logical, allocatable :: is_undecided(:)
    !> the matrix of the closed rows is singular, or x and y were not found; then the derivatives are of no use
    logical :: is_singular = .false.
  end type friction_derivative_t

  !> Forces of up to three rows that change together, by their shares. The same sum of the first n_equation rows is their equation.
  type :: unknown_t
    integer :: rows(3) = 0
    integer :: n_parts = 0
    integer :: n_equation = 0
    real(rk) :: shares(3) = 0
    !> [length/force] k
    real(rk) :: softness = 0
  end type unknown_t

  !> What changes freely, what is at a border, and the direction of slip of each contact.
  type :: unknowns_t
    !> shapes (n_free) and (n_grazing)
    type(unknown_t), allocatable :: free(:)
    type(unknown_t), allocatable :: grazing(:)
    !> zero where a contact does not slip; shape (2, n_contacts)
    real(rk), allocatable :: directions(:, :)
    !> contacts with friction that have neither a force nor a gap, and those that get friction and do not slip; 1-based
    integer, allocatable :: touching(:)
    integer, allocatable :: resting(:)
  end type unknowns_t

contains

  !> Computes the derivatives. Requires: the solution is that of the step.
  subroutine differentiate_friction(matrix, contacts, step, solution, openings, friction, derivative)
    !> [length/force] W, shape (n_rows, n_rows)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_step_t), intent(in) :: step
    type(friction_solution_t), intent(in) :: solution
    !> [length] q' + s_0' (s_0' in tangential rows) for each direction, shape (n_rows, n_directions)
    real(rk), contiguous, intent(in) :: openings(:, :)
    !> [-] change of the coefficients of friction, shape (n_contacts, n_directions)
    real(rk), intent(in) :: friction(:, :)
    type(friction_derivative_t), intent(out) :: derivative
    real(rk), dimension(size(openings, 1), size(openings, 2)) :: known, shifted
    type(unknowns_t) :: unknowns
    integer :: i, k

    call list_unknowns(matrix, contacts, step, solution, any(abs(friction) > 0, dim=2), unknowns)
    derivative%n_grazing = size(unknowns%grazing) + size(unknowns%touching) + size(unknowns%resting)
    allocate (derivative%is_one_sided(size(openings, 2)), derivative%is_undecided(size(openings, 2)), source=.false.)
    known = 0
    do k = 1, contacts%n_contacts
      associate (rows => contacts%tangents(:contacts%n_tangents(k), k))
        do i = 1, size(rows)
          known(rows(i), :) = friction(k, :) * solution%lambda(k) * unknowns%directions(i, k)
        end do
      end associate
    end do
    shifted = openings
    do i = 1, size(openings, 2)
      call multiply(1.0_rk, matrix, known(:, i), 1.0_rk, shifted(:, i))
    end do
    call solve_changes(matrix, unknowns, known, shifted, derivative)
    if (derivative%is_singular) return
    derivative%openings = openings
    do i = 1, size(openings, 2)
      call multiply(1.0_rk, matrix, derivative%forces(:, i), 1.0_rk, derivative%openings(:, i))
    end do
    do k = 1, size(unknowns%free)
      ! rounding must not add up over many steps
      if (unknowns%free(k)%n_equation == 1) derivative%openings(unknowns%free(k)%rows(1), :) = 0
    end do
    call decide(matrix, unknowns, openings, friction, derivative)
  end subroutine differentiate_friction

  !> Sets is_undecided, and is_one_sided where a contact with friction opens that has no gap.
  pure subroutine decide(matrix, unknowns, openings, friction, derivative)
    real(rk), intent(in) :: matrix(:, :)
    type(unknowns_t), intent(in) :: unknowns
    real(rk), intent(in) :: openings(:, :)
    real(rk), intent(in) :: friction(:, :)
    type(friction_derivative_t), intent(inout) :: derivative
    real(rk) :: noise
    integer :: i, k

    do i = 1, size(openings, 2)
      do k = 1, size(unknowns%touching)
        associate (row => unknowns%touching(k))
          noise = rounding_of_data * (abs(openings(row, i)) + sum(abs(matrix(row, :) * derivative%forces(:, i))))
          derivative%is_undecided(i) = derivative%is_undecided(i) .or. derivative%openings(row, i) < -noise
          derivative%is_one_sided(i) = derivative%is_one_sided(i) .or. derivative%openings(row, i) > noise
        end associate
      end do
      derivative%is_undecided(i) = derivative%is_undecided(i) .or. any(abs(friction(unknowns%resting, i)) > 0)
    end do
  end subroutine decide

  subroutine list_unknowns(matrix, contacts, step, solution, gets_friction, unknowns)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_step_t), intent(in) :: step
    type(friction_solution_t), intent(in) :: solution
    !> whether the coefficient of friction changes, shape (n_contacts)
    logical, intent(in) :: gets_friction(:)
    type(unknowns_t), intent(out) :: unknowns
    real(rk), dimension(size(matrix, 1)) :: diagonal, noise, slip_noise
    real(rk) :: force(2), slip(2)
    integer :: i, k, n

    allocate (unknowns%free(0), unknowns%grazing(0), unknowns%touching(0), unknowns%resting(0))
    allocate (unknowns%directions(2, contacts%n_contacts), source=0.0_rk)
    noise = rounding_of(rounding_of_data, matrix, step, solution, contacts%n_forces())
    ! a gap may be zero in data that were rounded; a slip is zero where nothing changes
    slip_noise = rounding_of(rounding, matrix, step, solution, contacts%n_forces())
    diagonal = [(matrix(k, k), k=1, size(matrix, 1))]
    ! rows of bodies that only contact holds may have a zero diagonal
    where (.not. diagonal > 0) diagonal = maxval(diagonal)
    do k = 1, contacts%n_contacts
      n = contacts%n_tangents(k)
      associate (normal => solution%lambda(k), rows => contacts%tangents(:n, k), f => step%friction(k), &
        largest => maxval(slip_noise(contacts%rows_of(k))))
        if (contacts%is_tied(k)) then
          call add_rows(unknowns%free, contacts%rows_of(k))
          cycle
        end if
        if (solution%states(k) == contact_open .or. normal * diagonal(k) <= noise(k)) then
          if (solution%openings(k) > noise(k)) cycle
          if (f > 0 .or. (n > 0 .and. gets_friction(k))) then
            unknowns%touching = [unknowns%touching, k]
          else
            call add_rows(unknowns%grazing, [k])
          end if
          cycle
        end if
        force = 0
        slip = 0
        force(:n) = solution%lambda(rows)
        slip(:n) = -solution%openings(rows) - step%origins(rows)
        if (n == 0 .or. .not. (f > 0 .or. gets_friction(k))) then
          call add_rows(unknowns%free, [k])
        else if (.not. f > 0) then
          if (norm2(slip) > largest) then
            unknowns%directions(:, k) = slip / norm2(slip)
          else
            unknowns%resting = [unknowns%resting, k]
          end if
          call add_rows(unknowns%free, [k])
        else if ((f * normal - norm2(force)) * maxval(diagonal(rows)) > largest) then
          call add_rows(unknowns%free, contacts%rows_of(k))
        else if (.not. norm2(force) > 0) then
          ! friction that is only rounding
          unknowns%touching = [unknowns%touching, k]
        else
          associate (d => unknowns%directions(:, k))
            d = force / norm2(force)
            call add_sum(unknowns%free, [k, rows], [1.0_rk, f * d(:n)], 1)
            if (n == 2) call add_sum(unknowns%free, rows, [-d(2), d(1)], 2, &
              merge(norm2(slip), 0.0_rk, norm2(slip) > largest) / (f * normal))
            if (norm2(slip) <= largest) call add_sum(unknowns%grazing, rows, -d(:n), n)
          end associate
        end if
      end associate
    end do
    do i = contacts%n_forces() + 1, contacts%n_rows()
      call add_rows(unknowns%free, [i])
    end do
  end subroutine list_unknowns

  !> Returns what counts as rounding in each row [length]: of q and the origins, and of the terms of W lambda; and what forces that
  !> are rounding move.
  pure function rounding_of(share, matrix, step, solution, n_forces) result(noise)
    !> [-] of q and the origins
    real(rk), intent(in) :: share
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_step_t), intent(in) :: step
    type(friction_solution_t), intent(in) :: solution
    integer, intent(in) :: n_forces
    real(rk) :: noise(size(matrix, 1)), moved(size(matrix, 1))
    integer :: k

    noise = share * (abs(step%q) + step%terms)
    noise(:n_forces) = noise(:n_forces) + share * abs(step%origins(:n_forces))
    do k = 1, size(noise)
      noise = noise + rounding * abs(matrix(:, k) * solution%lambda(k))
    end do
    moved = 0
    do k = 1, n_forces
      if (matrix(k, k) > 0) moved = max(moved, abs(matrix(:, k)) * (noise(k) / matrix(k, k)))
    end do
    noise = noise + moved
  end function rounding_of

  !> Adds an unknown for each row.
  pure subroutine add_rows(list, rows)
    type(unknown_t), allocatable, intent(inout) :: list(:)
    integer, intent(in) :: rows(:)
    integer :: i

    do i = 1, size(rows)
      call add_sum(list, rows(i:i), [1.0_rk], 1)
    end do
  end subroutine add_rows

  !> Adds an unknown of several rows.
  pure subroutine add_sum(list, rows, shares, n_equation, softness)
    type(unknown_t), allocatable, intent(inout) :: list(:)
    integer, intent(in) :: rows(:)
    real(rk), intent(in) :: shares(:)
    integer, intent(in) :: n_equation
    !> default: 0
    real(rk), intent(in), optional :: softness
    type(unknown_t) :: one

    one%n_parts = size(rows)
    one%n_equation = n_equation
    one%rows(:size(rows)) = rows
    one%shares(:size(rows)) = shares
    if (present(softness)) one%softness = softness
    list = [list, one]
  end subroutine add_sum

  !> Computes the changes of the forces, and is_one_sided; is_singular where there are none.
  subroutine solve_changes(matrix, unknowns, known, openings, derivative)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(unknowns_t), intent(in) :: unknowns
    !> [force] known part of the changes, and [length] q' + s_0' + W known, shapes (n_rows, n_directions)
    real(rk), contiguous, intent(in) :: known(:, :)
    real(rk), contiguous, intent(in) :: openings(:, :)
    type(friction_derivative_t), intent(inout) :: derivative
    type(lu_t) :: factors
    real(rk) :: moved(size(matrix, 1), size(unknowns%free)), square(size(unknowns%free), size(unknowns%free))
    real(rk) :: changes(size(unknowns%free), size(openings, 2)), closing(size(unknowns%grazing), size(openings, 2))
    integer :: i

    associate (free => unknowns%free, grazing => unknowns%grazing)
      moved = columns_of(matrix, free)
      square = equations_of(free, moved)
      do i = 1, size(free)
        square(i, i) = square(i, i) + free(i)%softness
      end do
      call factors%factor(square)
      derivative%is_singular = factors%is_singular
      if (derivative%is_singular) return
      changes = -factors%solve(equations_of(free, openings))
      closing = 0
      if (size(grazing) > 0) call close_grazing(matrix, unknowns, factors, moved, openings, changes, closing, derivative)
      if (derivative%is_singular) return
      derivative%forces = known
      call add_forces(free, changes, derivative%forces)
      call add_forces(grazing, closing, derivative%forces)
    end associate
  end subroutine solve_changes

  !> Solves for the unknowns at borders, and corrects the others.
  subroutine close_grazing(matrix, unknowns, factors, moved, openings, changes, closing, derivative)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(unknowns_t), intent(in) :: unknowns
    type(lu_t), intent(in) :: factors
    !> [length/force] what the free unknowns move, shape (n_rows, n_free)
    real(rk), contiguous, intent(in) :: moved(:, :)
    real(rk), contiguous, intent(in) :: openings(:, :)
    !> [force] of the free unknowns, shape (n_free, n_directions)
    real(rk), intent(inout) :: changes(:, :)
    !> [force] of those at borders, shape (n_grazing, n_directions)
    real(rk), intent(out) :: closing(:, :)
    type(friction_derivative_t), intent(inout) :: derivative
    real(rk) :: beside(size(matrix, 1), size(closing, 1)), coupling(size(changes, 1), size(closing, 1))
    real(rk) :: rows(size(closing, 1), size(changes, 1)), schur(size(closing, 1), size(closing, 1))
    real(rk), dimension(size(closing, 1), size(closing, 2)) :: forced, sizes
    type(lcp_solution_t) :: solution
    integer :: i

    associate (free => unknowns%free, grazing => unknowns%grazing)
      beside = columns_of(matrix, grazing)
      coupling = factors%solve(equations_of(free, beside))
      rows = equations_of(grazing, moved)
      schur = equations_of(grazing, beside) - matmul(rows, coupling)
      forced = equations_of(grazing, openings) + matmul(rows, changes)
      sizes = equations_of(grazing, abs(openings), .true.) + matmul(abs(rows), abs(changes))
    end associate
    where (abs(forced) <= rounding_of_data * sizes) forced = 0
    do i = 1, size(closing, 2)
      derivative%is_one_sided(i) = any(abs(forced(:, i)) > 0)
      call solve_lcp(schur, forced(:, i), [logical ::], solution)
      derivative%is_singular = derivative%is_singular .or. solution%reason <= 0
      closing(:, i) = solution%lambda
      changes(:, i) = changes(:, i) - matmul(coupling, closing(:, i))
    end do
  end subroutine close_grazing

  !> Returns what the unknowns move, [length/force], shape (n_rows, size(list)).
  pure function columns_of(matrix, list) result(columns)
    real(rk), intent(in) :: matrix(:, :)
    type(unknown_t), intent(in) :: list(:)
    real(rk) :: columns(size(matrix, 1), size(list))
    integer :: a, i

    columns = 0
    do i = 1, size(list)
      do a = 1, list(i)%n_parts
        columns(:, i) = columns(:, i) + list(i)%shares(a) * matrix(:, list(i)%rows(a))
      end do
    end do
  end function columns_of

  !> Returns the sums of rows that the equations of the unknowns ask for, shape (size(list), size(values, 2)).
  pure function equations_of(list, values, is_absolute) result(sums)
    type(unknown_t), intent(in) :: list(:)
    !> shape (n_rows, any)
    real(rk), intent(in) :: values(:, :)
    !> with absolute values of the shares; default: no
    logical, intent(in), optional :: is_absolute
    real(rk) :: sums(size(list), size(values, 2))
    integer :: a, i

    sums = 0
    do i = 1, size(list)
      do a = 1, list(i)%n_equation
        associate (share => merge(abs(list(i)%shares(a)), list(i)%shares(a), present(is_absolute)))
          sums(i, :) = sums(i, :) + share * values(list(i)%rows(a), :)
        end associate
      end do
    end do
  end function equations_of

  !> Adds the forces of unknowns to those of the rows.
  pure subroutine add_forces(list, changes, forces)
    type(unknown_t), intent(in) :: list(:)
    !> shape (size(list), n_directions)
    real(rk), intent(in) :: changes(:, :)
    !> shape (n_rows, n_directions)
    real(rk), intent(inout) :: forces(:, :)
    integer :: a, i

    do i = 1, size(list)
      do a = 1, list(i)%n_parts
        forces(list(i)%rows(a), :) = forces(list(i)%rows(a), :) + list(i)%shares(a) * changes(i, :)
      end do
    end do
  end subroutine add_forces
end module sig_friction_derivative
