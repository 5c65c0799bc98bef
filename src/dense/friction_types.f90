! SPDX-License-Identifier: BSD-3-Clause
!> The condensed step problem of Coulomb friction, its answer, its workspace, and what its methods share: the projections of the
!> forces of one contact.
!>
!> A contact has a normal force lambda_n and up to two tangential forces lambda_t. With w = q + W lambda and v = w_t + s_0, which is
!> the opposite of the slip of this step:
!>
!>     lambda_n = max(0, y_n),  lambda_t = P_r(y_t),  y_n = lambda_n - c_n w_n,  y_t = lambda_t - c_t v,  r = f max(0, y_n)
!>
!> for any c > 0; P_r is the projection onto the interval or disc of radius r. A tied contact has w_n = 0 and v = 0. Bodies that
!> only contact holds have motions: further unknowns without a sign, whose rows are the equilibrium of these bodies, w = 0.
module sig_friction_types
  use sig_dense_kernels, only: add_columns_and_sizes
  use sig_kinds, only: rk
  use sig_lcp_types, only: lcp_solution_t, lcp_workspace_t
  use sig_reasons, only: reason_not_finite
  implicit none(type, external)
  private
  public :: friction_contacts_t, friction_solution_t, friction_workspace_t, friction_unknown_t, kept_factors_t, law_exchange_t
  public :: scale_projections, sum_up, project, project_contact, length

  !> states of a contact; a closed contact without friction slips
  integer, parameter, public :: contact_open = 0
  integer, parameter, public :: contact_sticks = 1
  integer, parameter, public :: contact_slips = 2

  !> a run of Newton's method ends after this number of steps
  integer, parameter, public :: most_steps = 60
  !> most iterations with kept factors
  integer, parameter, public :: most_searched = 30
  !> most rows whose laws may differ from those of kept factors
  integer, parameter, public :: most_exchanged = 256

  !> What each row of W belongs to. The rows are the normal rows of all contacts, in their order; then all tangential rows; then one
  !> row for each motion.
  type :: friction_contacts_t
    integer :: n_contacts = 0
    !> number of motions of bodies that only contact holds. Their rows of W are [-N', 0], and their columns [N; 0]
    integer :: n_motions = 0
    !> rows of the tangential forces of each contact, the second one 0 where there is one, both 0 where there is none; shape (2,
    !> n_contacts)
    integer, allocatable :: tangents(:, :)
    !> whether the contact neither opens nor slips, whatever its forces are; shape (n_contacts)
    logical, allocatable :: is_tied(:)
  contains
    procedure :: n_rows
    procedure :: n_forces
    procedure :: n_tangents
    procedure :: rows_of
    procedure :: tangential
    procedure :: take_part
  end type friction_contacts_t

  !> The answer of a step, and the start of the next one.
  type :: friction_solution_t
    !> [force] forces of all rows, then the amplitudes of the motions; shape (n_rows)
    real(rk), allocatable :: lambda(:)
    !> [length] w = q + W lambda: gaps, the opposite of the positions of slip, and in rows of motions 0; exactly 0 where a contact
    !> is closed, and exactly -s_0 where it sticks; shape (n_rows)
    real(rk), allocatable :: openings(:)
    !> contact_open, contact_sticks or contact_slips; shape (n_contacts)
    integer, allocatable :: states(:)
    !> steps of Newton's method, and rounds of sweeps between its runs
    integer :: n_steps = 0
    integer :: n_rounds = 0
    !> [-] natural residual: largest difference of both sides of the equations at the head of this file, as a length over the sum of
    !> the sizes of the terms of its row; huge where there is no answer
    real(rk) :: residual = huge(1.0_rk)
    !> one of sig_reasons
    integer :: reason = reason_not_finite
  end type friction_solution_t

  !> An unknown of a step of Newton's method, and an equation for it (sig_friction_unknowns).
  type :: friction_unknown_t
    !> rows of its contact, or of its motion
    integer :: n_rows = 0
    integer :: rows(3) = 0
    !> one of them, which no other unknown of the same step has: the place of the unknown in factors
    integer :: home = 0
    !> shares of the unknown in z; of y and z in the equation
    real(rk) :: moves(3) = 0
    real(rk) :: of_y(3) = 0
    real(rk) :: of_z(3) = 0
  end type friction_unknown_t

  !> Rows whose laws are not those of the factors (sig_friction_exchange), and what was solved for such rows since these factors.
  type :: law_exchange_t
    !> the rows C: their number, contacts, which row of the contact, and laws of J as equations, whose home is this row
    integer :: n = 0
    integer, allocatable :: contacts(:)
    integer, allocatable :: slots(:)
    type(friction_unknown_t), allocatable :: laws(:)
    !> place of each row among the unknowns of J, 0: none; shape (capacity)
    integer, allocatable :: place_in_new(:)
    !> Z_j, and in which column that of a row is, 0: nowhere; shapes (capacity, most_exchanged) and (capacity)
    integer :: n_columns = 0
    real(rk), allocatable :: columns(:, :)
    integer, allocatable :: column_of(:)
    !> y of the columns in some rows; which rows these are, and the place of a row among them, 0: none
    integer :: n_images = 0
    real(rk), allocatable :: images(:, :)
    integer, allocatable :: image_rows(:)
    integer, allocatable :: image_of(:)
    !> equations of r: matrix, then its factors, pivots, and right-hand side, then r
    real(rk), allocatable :: square(:, :)
    integer, allocatable :: pivots(:)
    real(rk), allocatable :: x(:)
    !> independent numbers, shape (capacity)
    real(rk), allocatable :: known(:)
  contains
    procedure :: clear
    procedure :: reserve => reserve_exchange
  end type law_exchange_t

  !> What a step leaves for the next ones (sig_friction_kept): which matrix was factored, and work arrays. The factors themselves
  !> are those of friction_workspace_t.
  type :: kept_factors_t
    !> whether the numbers of the next five entries are set
    logical :: is_set = .false.
    !> [-] f, and states, directions and softness as in friction_workspace_t; shapes (n_contacts) and (2, n_contacts)
    real(rk), allocatable :: friction(:)
    integer, allocatable :: states(:)
    real(rk), allocatable :: directions(:, :)
    real(rk), allocatable :: softness(:)
    !> whether the unknowns are openings
    logical :: is_inverse = .false.
    !> [-] operations of the steps since then
    real(rk) :: spent = 0
    !> [-] operations of all linear problems so far, of factors and iterations, for benchmarks
    real(rk) :: n_operations = 0
    !> whether the workspace has these factors; if not, they are computed anew, with the same bits
    logical :: is_factored = .false.
    !> whether W was found to be finite
    logical :: is_checked = .false.
    !> order of the factors, their unknowns, and the place of a row among these, 0: none; shape (capacity)
    integer :: n = 0
    type(friction_unknown_t), allocatable :: unknowns(:)
    integer, allocatable :: places(:)
    type(law_exchange_t) :: exchange
    !> dependent and independent numbers of all rows, and the forces without openings; shapes (capacity)
    real(rk), allocatable :: y(:)
    real(rk), allocatable :: z(:)
    !> directions of a search, and what they change in y; shape (capacity, most_searched + 1)
    real(rk), allocatable :: basis(:, :)
    real(rk), allocatable :: images(:, :)
  contains
    procedure :: forget
    procedure :: save
    procedure :: restore
  end type kept_factors_t

  !> Work space for one problem after the other. It grows to the largest problem. Two threads must not use the same one.
  type :: friction_workspace_t
    integer :: capacity = 0
    integer :: contact_capacity = 0
    !> [-] natural residual at which Newton's method ends
    real(rk) :: tolerance = 0
    !> [-] lowest natural residual of the last run of Newton's method
    real(rk) :: lowest = 0
    !> [length] q, with the origins of slip added: the openings without forces, shape (capacity)
    real(rk), allocatable :: free(:)
    !> [length] w with the origins added, and the sizes of its terms, shape (capacity)
    real(rk), allocatable :: w(:)
    real(rk), allocatable :: row_size(:)
    !> [force/length] weight of the equilibrium in sweeps: W + weight N N' has no motion without stiffness
    real(rk) :: weight = 0
    !> [force/length] c_n and c_t of each contact, shape (2, contact_capacity)
    real(rk), allocatable :: c(:, :)
    !> states by the projection; direction of y_t; [length/force] what a force across this direction moves besides, in a step of
    !> Newton's method, huge where there is no such force; shapes (contact_capacity) and (2, contact_capacity)
    integer, allocatable :: states(:)
    real(rk), allocatable :: directions(:, :)
    real(rk), allocatable :: softness(:)
    !> sets of states already seen, shape (contact_capacity, most_steps)
    integer, allocatable :: history(:, :)
    !> unknowns of a step of Newton's method with their equations, shape (capacity)
    type(friction_unknown_t), allocatable :: unknowns(:)
    !> factors, pivots, right-hand side, signs for the estimate of the condition number
    real(rk), allocatable :: factors(:, :)
    integer, allocatable :: pivots(:)
    real(rk), allocatable :: x(:)
    real(rk), allocatable :: work(:)
    integer, allocatable :: signs(:)
    type(kept_factors_t) :: kept
    !> for problems without friction
    type(lcp_workspace_t) :: lcp
    type(lcp_solution_t) :: lcp_solution
  contains
    procedure :: reserve
    procedure :: reserve_projections
  end type friction_workspace_t

contains

  !> Returns the number of rows of W.
  pure integer function n_rows(self)
    class(friction_contacts_t), intent(in) :: self

    n_rows = self%n_forces() + self%n_motions
  end function n_rows

  !> Returns the number of rows without those of motions.
  pure integer function n_forces(self)
    class(friction_contacts_t), intent(in) :: self

    n_forces = self%n_contacts
    if (allocated(self%tangents)) n_forces = n_forces + count(self%tangents > 0)
  end function n_forces

  !> Returns the number of tangential rows of a contact, 0 to 2.
  pure integer function n_tangents(self, contact)
    class(friction_contacts_t), intent(in) :: self
    integer, intent(in) :: contact

    n_tangents = merge(1, 0, self%tangents(1, contact) > 0) + merge(1, 0, self%tangents(2, contact) > 0)
  end function n_tangents

  !> Returns the rows of a contact: its normal row, then its tangential rows; shape (1 to 3).
  pure function rows_of(self, contact) result(rows)
    class(friction_contacts_t), intent(in) :: self
    integer, intent(in) :: contact
    integer :: rows(1 + count(self%tangents(:, contact) > 0))

    rows(1) = contact
    rows(2:) = self%tangents(:size(rows) - 1, contact)
  end function rows_of

  !> Returns the numbers of the tangential rows of a contact; 0 where there is none. It allocates nothing.
  pure function tangential(self, contact, numbers) result(pair)
    class(friction_contacts_t), intent(in) :: self
    integer, intent(in) :: contact
    !> of all rows, shape (n_rows)
    real(rk), intent(in) :: numbers(:)
    real(rk) :: pair(2)
    integer :: i

    do i = 1, 2
      pair(i) = 0
      if (self%tangents(i, contact) > 0) pair(i) = numbers(self%tangents(i, contact))
    end do
  end function tangential

  !> Takes some contacts and motions alone.
  pure subroutine take_part(self, has_contact, has_motion, rows, part)
    class(friction_contacts_t), intent(in) :: self
    !> shapes (n_contacts) and (n_motions)
    logical, intent(in) :: has_contact(:)
    logical, intent(in) :: has_motion(:)
    !> rows of the part, 1-based, in its order
    integer, allocatable, intent(out) :: rows(:)
    type(friction_contacts_t), intent(out) :: part
    integer :: i, k, n

    rows = pack([(k, k=1, self%n_contacts)], has_contact)
    part%n_contacts = size(rows)
    part%n_motions = count(has_motion)
    part%is_tied = self%is_tied(rows)
    part%tangents = self%tangents(:, rows)
    n = size(rows)
    do k = 1, part%n_contacts
      do i = 1, 2
        if (part%tangents(i, k) <= 0) cycle
        rows = [rows, part%tangents(i, k)]
        n = n + 1
        part%tangents(i, k) = n
      end do
    end do
    rows = [rows, self%n_forces() + pack([(k, k=1, self%n_motions)], has_motion)]
  end subroutine take_part

  !> Allocates the arrays for a problem. If they are large enough already, they stay as they are; otherwise all contents are lost.
  pure subroutine reserve(self, contacts)
    class(friction_workspace_t), intent(inout) :: self
    type(friction_contacts_t), intent(in) :: contacts

    associate (n => contacts%n_rows(), n_contacts => contacts%n_contacts)
      if (n > self%capacity .or. .not. allocated(self%free)) then
        if (allocated(self%free)) deallocate (self%free, self%w, self%row_size, self%unknowns, self%factors, self%pivots, self%x, &
          self%work, self%signs, self%kept%unknowns, self%kept%places, self%kept%y, self%kept%z, self%kept%basis, self%kept%images)
        allocate (self%free(n), self%w(n), self%row_size(n), self%unknowns(n), self%factors(n, n), self%pivots(n), self%x(n), &
          self%work(n), self%signs(n), self%kept%unknowns(n), self%kept%places(n), self%kept%y(n), self%kept%z(n), &
          self%kept%basis(n, most_searched + 1), self%kept%images(n, most_searched))
        call self%kept%exchange%reserve(n)
        ! what factors are computed from may have been restored before there was room for them
        self%kept%is_factored = .false.
        self%kept%is_checked = .false.
        if (allocated(self%kept%states)) self%kept%is_set = self%kept%is_set .and. size(self%kept%states) == n_contacts
        self%capacity = n
      end if
      if (n_contacts > self%contact_capacity .or. .not. allocated(self%c)) then
        if (allocated(self%c)) deallocate (self%c, self%states, self%directions, self%softness, self%history)
        allocate (self%c(2, n_contacts), self%states(n_contacts), self%directions(2, n_contacts), self%softness(n_contacts), &
          self%history(n_contacts, most_steps))
        self%contact_capacity = n_contacts
      end if
    end associate
  end subroutine reserve

  !> Allocates only what `sum_up` and `project` need: the openings, the sizes of their terms, c, states, directions and softness.
  !> Requires: neither this nor `reserve` was called before.
  pure subroutine reserve_projections(self, contacts)
    class(friction_workspace_t), intent(inout) :: self
    type(friction_contacts_t), intent(in) :: contacts

    associate (n => contacts%n_rows(), n_contacts => contacts%n_contacts)
      allocate (self%free(n), self%w(n), self%row_size(n), self%c(2, n_contacts), self%directions(2, n_contacts), source=0.0_rk)
      allocate (self%states(n_contacts), source=contact_open)
      allocate (self%softness(n_contacts), source=huge(1.0_rk))
    end associate
  end subroutine reserve_projections

  pure subroutine reserve_exchange(self, capacity)
    class(law_exchange_t), intent(inout) :: self
    integer, intent(in) :: capacity
    integer :: most

    most = min(max(capacity / 3, 3), most_exchanged)
    if (allocated(self%contacts)) deallocate (self%contacts, self%slots, self%laws, self%place_in_new, self%columns, &
      self%column_of, self%images, self%image_rows, self%image_of, self%square, self%pivots, self%x, self%known)
    allocate (self%contacts(most), self%slots(most), self%laws(most), self%place_in_new(capacity), self%columns(capacity, most), &
      self%column_of(capacity), self%images(3 * most, most), self%image_rows(3 * most), self%image_of(capacity), &
      self%square(most, most), self%pivots(most), self%x(most), self%known(capacity))
    call self%clear()
  end subroutine reserve_exchange

  !> Forgets all columns.
  pure subroutine clear(self)
    class(law_exchange_t), intent(inout) :: self

    self%n_columns = 0
    self%n_images = 0
    self%column_of = 0
    self%image_of = 0
  end subroutine clear

  !> Begins a history, or goes on with another matrix.
  pure subroutine forget(self)
    class(kept_factors_t), intent(inout) :: self

    self%is_set = .false.
    self%is_factored = .false.
    self%is_checked = .false.
    self%is_inverse = .false.
    self%spent = 0
  end subroutine forget

  !> Gives the numbers that the factors are computed from; zeros where there are none.
  pure subroutine save(self, numbers)
    class(kept_factors_t), intent(in) :: self
    !> shape (3 + 5 n_contacts)
    real(rk), intent(out) :: numbers(:)

    numbers = 0
    if (.not. self%is_set) return
    numbers(:3) = [1.0_rk, merge(1.0_rk, 0.0_rk, self%is_inverse), self%spent]
    numbers(4:) = [self%friction, real(self%states, rk), reshape(self%directions, [size(self%directions)]), self%softness]
  end subroutine save

  !> Goes back to what `save` gave. is_valid: the numbers are such; otherwise this is `forget`.
  pure subroutine restore(self, numbers, is_valid)
    class(kept_factors_t), intent(inout) :: self
    real(rk), intent(in) :: numbers(:)
    logical, intent(out) :: is_valid
    real(rk) :: present(size(numbers))
    integer :: k, n

    call self%save(present)
    is_valid = .true.
    if (all(abs(numbers - present) <= 0)) return
    call self%forget()
    n = (size(numbers) - 3) / 5
    is_valid = any(abs(numbers(1) - [0, 1]) <= 0) .and. any(abs(numbers(2) - [0, 1]) <= 0) .and. numbers(3) >= 0
    do k = 4 + n, 3 + 2 * n
      is_valid = is_valid .and. any(abs(numbers(k) - [contact_open, contact_sticks, contact_slips]) <= 0)
    end do
    if (.not. is_valid) return
    self%is_set = numbers(1) > 0
    self%is_inverse = numbers(2) > 0
    self%spent = numbers(3)
    self%friction = numbers(4:3 + n)
    self%states = nint(numbers(4 + n:3 + 2 * n))
    self%directions = reshape(numbers(4 + 2 * n:3 + 4 * n), [2, n])
    self%softness = numbers(4 + 4 * n:)
  end subroutine restore

  !> Sets the weight of the equilibrium, 1 / max |N|, and c_n = 1 / W_nn and c_t = 1 / max W_tt of each contact. With motions, these
  !> are the diagonal entries of W + weight N N'.
  pure subroutine scale_projections(matrix, contacts, workspace)
    !> W, shape (n_rows, n_rows)
    real(rk), intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk) :: diagonal(size(matrix, 1)), largest, smallest
    integer :: i, k, n

    n = contacts%n_forces()
    workspace%weight = 0
    if (contacts%n_motions > 0) largest = maxval(abs(matrix(:n, n + 1:)))
    if (contacts%n_motions > 0 .and. n > 0) workspace%weight = 1 / max(largest, tiny(largest))
    do i = 1, n
      diagonal(i) = matrix(i, i) + workspace%weight * sum(matrix(i, n + 1:)**2)
    end do
    ! a row that nothing moves
    smallest = max(epsilon(smallest) * maxval(diagonal(:n)), tiny(smallest))
    diagonal = max(diagonal, smallest)
    do k = 1, contacts%n_contacts
      workspace%c(:, k) = 1 / diagonal(k)
      if (contacts%tangents(1, k) > 0) workspace%c(2, k) = 1 / maxval(diagonal(contacts%tangents(:contacts%n_tangents(k), k)))
    end do
  end subroutine scale_projections

  !> Computes in the workspace w = W lambda + free and the sum of the sizes of the terms of each row.
  pure subroutine sum_up(matrix, lambda, workspace)
    !> W, shape (n_rows, n_rows)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> [force] shape (n_rows)
    real(rk), contiguous, intent(in) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace

    associate (n => size(lambda))
      workspace%w(:n) = workspace%free(:n)
      workspace%row_size(:n) = abs(workspace%free(:n))
      call add_columns_and_sizes(matrix, lambda, workspace%w(:n), workspace%row_size(:n))
    end associate
  end subroutine sum_up

  !> Sets the states, the directions and the softness of all contacts by the projection of y, and computes the natural residual.
  !> Requires: scale_projections, and sum_up for these forces.
  pure subroutine project(friction, contacts, lambda, workspace, residual)
    !> [-] f of each contact, >= 0; shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] shape (n_rows)
    real(rk), intent(in) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    !> [-]
    real(rk), intent(out) :: residual
    integer :: i, k

    residual = 0
    do k = 1, contacts%n_contacts
      call project_contact(friction, contacts, k, lambda, workspace, residual)
    end do
    do i = size(lambda) - contacts%n_motions + 1, size(lambda)
      call compare(abs(workspace%w(i)), workspace%row_size(i), residual)
    end do
  end subroutine project

  !> Does the work of project for contact k; the residual is raised.
  pure subroutine project_contact(friction, contacts, k, lambda, workspace, residual)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: k
    real(rk), intent(in) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk), intent(inout) :: residual
    real(rk) :: force, projected, radius, tangential(2), y(2)
    integer :: i, n

    n = contacts%n_tangents(k)
    associate (c => workspace%c(:, k), w => workspace%w, sizes => workspace%row_size)
      if (contacts%is_tied(k)) then
        workspace%states(k) = contact_sticks
        call compare(abs(w(k)), sizes(k), residual)
        do i = 1, n
          call compare(abs(w(contacts%tangents(i, k))), sizes(contacts%tangents(i, k)), residual)
        end do
        return
      end if
      projected = max(0.0_rk, lambda(k) - c(1) * w(k))
      call compare(abs(lambda(k) - projected) / c(1), sizes(k), residual)
      radius = friction(k) * projected
      tangential = contacts%tangential(k, lambda)
      y = tangential - c(2) * contacts%tangential(k, w)
      force = length(y)
      call set_state(projected, radius, y, force, c(2), n, workspace, k)
      if (force > radius) y = radius * (y / force)
      if (n > 0) call compare(length(tangential - y) / c(2), maxval(contacts%tangential(k, sizes)), residual)
    end associate
  end subroutine project_contact

  !> Returns the length of a vector in a plane, which in most problems has one entry.
  pure real(rk) function length(y)
    real(rk), intent(in) :: y(2)

    length = abs(y(1))
    if (.not. abs(y(2)) <= 0) length = hypot(y(1), y(2))
  end function length

  !> Sets the state of contact k, and where it slips the direction of y and the softness (1 - b) / (b c) with b = r / |y|: the
  !> derivative of r y / |y| across y is b, so that lambda_e = b (lambda_e - c v_e) there.
  pure subroutine set_state(normal, radius, y, force, c, n_tangents, workspace, k)
    !> [force] max(0, y_n)
    real(rk), intent(in) :: normal
    !> [force] r
    real(rk), intent(in) :: radius
    !> [force] y_t, shape (2)
    real(rk), intent(in) :: y(:)
    !> [force] |y_t|
    real(rk), intent(in) :: force
    !> [force/length] c_t
    real(rk), intent(in) :: c
    integer, intent(in) :: n_tangents
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: k
    real(rk) :: share

    workspace%states(k) = contact_open
    if (.not. normal > 0) return
    workspace%states(k) = contact_slips
    workspace%directions(:, k) = 0
    workspace%softness(k) = huge(force)
    if (n_tangents == 0 .or. .not. radius > 0) return
    if (force <= radius) then
      workspace%states(k) = contact_sticks
      return
    end if
    share = radius / force
    workspace%directions(:, k) = y / force
    ! no radius is so small that the softness overflows
    if (n_tangents == 2 .and. share > epsilon(share)) workspace%softness(k) = (1 - share) / (share * c)
  end subroutine set_state

  !> Raises the residual to that of a row.
  pure subroutine compare(difference, size_of_row, residual)
    !> [length] >= 0
    real(rk), intent(in) :: difference
    !> [length] sum of the sizes of the terms
    real(rk), intent(in) :: size_of_row
    real(rk), intent(inout) :: residual

    if (.not. (difference <= huge(difference) .and. size_of_row <= huge(difference))) then
      residual = huge(residual)
    else if (difference > residual * size_of_row) then
      residual = max(residual, difference / max(size_of_row, tiny(size_of_row)))
    end if
  end subroutine compare
end module sig_friction_types
