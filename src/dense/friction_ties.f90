! SPDX-License-Identifier: BSD-3-Clause
!> Leaves tied contacts out of the step problem of Coulomb friction (sig_friction_types), because their laws are linear.
!>
!> Let E be the rows of tied contacts and of the motions that these determine, and R all other rows. With w_E = 0, where q_E has the
!> origins of slip in it,
!>
!>     lambda_E = X lambda_R - W_EE^-1 q_E,   X = -W_EE^-1 W_ER,   W' = W_RR + W_RE X,   q' = q_R - W_RE W_EE^-1 q_E.
!>
!> This is the problem of bodies that are bonded where they are tied. So contacts meet the compliance of the whole and not that of a
!> part that hangs on its ties alone, which may be larger by orders of magnitude, and steps have fewer unknowns.
!>
!> Tied contacts may hold a body partly: they determine as many motions as columns of N_T are independent. The other columns depend
!> on these, N_To = N_Th S. Then X = [0; -S] in the columns of such a motion o: it moves the bodies so that no tied contact opens,
!> and W' has the form of W again, with N' = N_o - N_h S and loads q_o - S' q_h.
module sig_friction_ties
  use sig_dense_kernels, only: add_columns_and_sizes, add_few_columns, add_product
  use sig_friction_types, only: contact_open, contact_sticks, friction_contacts_t, friction_solution_t
  use sig_independent_columns, only: independent_columns
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t
  use sig_reasons, only: reason_converged
  use sig_rounding, only: dependent, rounding
  implicit none(type, external)
  private
  public :: friction_ties_t

  !> [-] least reciprocal condition number of W_EE, and least part of a diagonal entry of W that W' may have: where ties are
  !> redundant, as in corners, or hold a contact, there is less
  real(rk), parameter :: least_reciprocal = 1.0e-12_rk
  real(rk), parameter :: least_left = 1.0e-10_rk

  type :: friction_ties_t
    !> whether tied contacts are left out; if not, nothing else is of use
    logical :: are_left_out = .false.
    !> the problem that is left, its rows R (1-based), and which contacts it has
    type(friction_contacts_t) :: others
    integer, allocatable :: rows(:)
    integer, allocatable :: contacts(:)
    !> E: normal rows of tied contacts, their tangential rows, then motions; and the numbers of tied contacts and of their rows
    integer, allocatable :: tied_rows(:)
    integer :: n_tied_contacts = 0
    integer :: n_tied = 0
    !> for each motion in E a row to which it alone adds, and what it adds to it [length/force]: that of an anchor; 0: none
    integer, allocatable, private :: anchors(:)
    real(rk), allocatable, private :: scales(:)
    !> [length/force] W', shape (size(rows), size(rows))
    real(rk), allocatable :: compliance(:, :)
    !> [-] X, shape (size(tied_rows), size(rows))
    real(rk), allocatable, private :: shares(:, :)
    !> [length/force] W_RE, shape (size(rows), size(tied_rows))
    real(rk), allocatable, private :: openings(:, :)
    !> of W_EE
    type(lu_t), private :: factors
  contains
    procedure :: create
    procedure :: reduce
    procedure :: expand
    procedure :: take_answer
    procedure :: give_answer
  end type friction_ties_t

contains

  !> Leaves all tied contacts out, with the motions that they hold. Where that would lose digits, are_left_out is false.
  subroutine create(self, matrix, contacts)
    class(friction_ties_t), intent(inout) :: self
    !> [length/force] W, shape (n_rows, n_rows)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts

    self%are_left_out = .false.
    if (.not. any(contacts%is_tied)) return
    call choose_rows(self, matrix, contacts)
    ! nothing is left that could hold the other motions
    if (self%others%n_contacts == 0 .and. self%others%n_motions > 0) return
    call self%factors%factor(matrix(self%tied_rows, self%tied_rows))
    if (.not. self%factors%reciprocal_condition > least_reciprocal) return
    self%openings = matrix(self%rows, self%tied_rows)
    self%shares = -self%factors%solve(matrix(self%tied_rows, self%rows))
    self%shares(:self%n_tied, self%others%n_forces() + 1:) = 0
    call find_anchors(self, matrix)
    call condense(self, matrix, self%are_left_out)
  end subroutine create

  !> Finds which motions tied contacts hold, and lists the rows.
  subroutine choose_rows(self, matrix, contacts)
    type(friction_ties_t), intent(inout) :: self
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    logical :: is_other(contacts%n_rows()), is_held(contacts%n_motions)
    integer :: k

    associate (n => contacts%n_forces(), last => contacts%n_rows())
      is_other = .true.
      do k = 1, contacts%n_contacts
        if (contacts%is_tied(k)) is_other(contacts%rows_of(k)) = .false.
      end do
      associate (tied => pack([(k, k=1, n)], .not. is_other(:n)))
        is_held = .false.
        if (contacts%n_motions > 0) is_held(independent_columns(matrix(tied, n + 1:), dependent * &
          maxval(abs(matrix(tied, n + 1:))))) = .true.
        self%n_tied_contacts = count(contacts%is_tied)
        self%n_tied = size(tied)
        self%tied_rows = [tied, pack([(k, k=n + 1, last)], is_held)]
      end associate
    end associate
    self%contacts = pack([(k, k=1, contacts%n_contacts)], .not. contacts%is_tied)
    call contacts%take_part(.not. contacts%is_tied, .not. is_held, self%rows, self%others)
  end subroutine choose_rows

  !> Finds rows to which motions in E add, and nothing else does.
  subroutine find_anchors(self, matrix)
    type(friction_ties_t), intent(inout) :: self
    real(rk), contiguous, intent(in) :: matrix(:, :)
    integer :: n_terms(size(matrix, 1))
    integer :: i, j

    n_terms = 0
    do j = 1, size(matrix, 2)
      where (abs(matrix(:, j)) > 0) n_terms = n_terms + 1
    end do
    associate (held => self%tied_rows(self%n_tied + 1:))
      self%anchors = 0 * held
      self%scales = 0.0_rk * held
      do i = 1, size(held)
        do j = 1, self%others%n_forces() + self%n_tied
          if (n_terms(j) /= 1 .or. .not. abs(matrix(j, held(i))) > 0) cycle
          self%anchors(i) = j
          self%scales(i) = matrix(j, held(i))
        end do
      end do
    end associate
  end subroutine find_anchors

  !> Computes W'.
  subroutine condense(self, matrix, is_accurate)
    type(friction_ties_t), intent(inout) :: self
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> whether enough of each diagonal entry of W is left
    logical, intent(out) :: is_accurate
    real(rk) :: terms
    integer :: i

    is_accurate = .true.
    self%compliance = matrix(self%rows, self%rows)
    call add_product(1.0_rk, self%openings, self%shares, self%compliance)
    associate (n => self%others%n_forces(), small => self%compliance)
      do i = 1, n
        terms = abs(matrix(self%rows(i), self%rows(i))) + sum(abs(self%openings(i, :) * self%shares(:, i)))
        is_accurate = is_accurate .and. small(i, i) >= least_left * terms
      end do
      small(:n, :n) = (small(:n, :n) + transpose(small(:n, :n))) / 2
      small(n + 1:, n + 1:) = 0
      small(n + 1:, :n) = -transpose(small(:n, n + 1:))
    end associate
  end subroutine condense

  !> Computes q', and lambda_E without other forces. What is only rounding in q' becomes 0.
  subroutine reduce(self, q, origins, forces, openings)
    class(friction_ties_t), intent(in) :: self
    !> [length] as of solve_friction, shape (n_rows)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: origins(:)
    !> [force] shape (size(tied_rows))
    real(rk), contiguous, intent(out) :: forces(:)
    !> [length] shape (size(rows))
    real(rk), contiguous, intent(out) :: openings(:)
    real(rk) :: sizes(size(openings))
    integer :: j

    associate (held => self%tied_rows(self%n_tied + 1:))
      forces = q(self%tied_rows)
      forces(:self%n_tied) = forces(:self%n_tied) + origins(self%tied_rows(:self%n_tied))
      forces = -self%factors%solve(forces)
      openings = q(self%rows)
      sizes = abs(openings)
      call add_columns_and_sizes(self%openings, forces, openings, sizes)
      ! self-stress of ties is in equilibrium, whatever rounding makes of it
      do j = self%others%n_forces() + 1, size(openings)
        associate (shares => self%shares(self%n_tied + 1:, j))
          openings(j) = q(self%rows(j)) + dot_product(shares, q(held))
          sizes(j) = abs(q(self%rows(j))) + dot_product(abs(shares), abs(q(held)))
        end associate
      end do
    end associate
    where (abs(openings) <= rounding * sizes) openings = 0
  end subroutine reduce

  !> Computes the forces and motions of all rows from those of the problem that is left.
  subroutine expand(self, forces, others, lambda)
    class(friction_ties_t), intent(in) :: self
    !> [force] from `reduce`
    real(rk), contiguous, intent(in) :: forces(:)
    !> [force] lambda_R, shape (size(rows))
    real(rk), contiguous, intent(in) :: others(:)
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: lambda(:)
    real(rk) :: of_tied(size(forces))

    of_tied = forces
    call add_few_columns(self%shares, others, of_tied)
    lambda(self%rows) = others
    lambda(self%tied_rows) = of_tied
  end subroutine expand

  !> Takes from an answer for all rows that of the problem that is left.
  pure subroutine take_answer(self, solution, others)
    class(friction_ties_t), intent(in) :: self
    type(friction_solution_t), intent(in) :: solution
    type(friction_solution_t), intent(inout) :: others

    others%reason = solution%reason
    if (solution%reason /= reason_converged) return
    others%lambda = solution%lambda(self%rows)
    others%openings = solution%openings(self%rows)
    others%states = solution%states(self%contacts)
  end subroutine take_answer

  !> Makes an answer for all rows from one of the problem that is left. Where there is none, only motions are not zero: those in
  !> which bodies slide or come off.
  subroutine give_answer(self, others, forces, q, origins, solution)
    class(friction_ties_t), intent(in) :: self
    type(friction_solution_t), intent(in) :: others
    !> [force] from `reduce`
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] of all rows
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: origins(:)
    type(friction_solution_t), intent(inout) :: solution
    integer :: i

    if (.not. allocated(solution%lambda)) then
      allocate (solution%lambda(size(origins)), solution%openings(size(origins)))
      allocate (solution%states(size(self%contacts) + self%n_tied_contacts))
    end if
    solution%reason = others%reason
    solution%residual = others%residual
    solution%n_steps = others%n_steps
    solution%n_rounds = others%n_rounds
    if (others%reason == reason_converged) then
      call self%expand(forces, others%lambda, solution%lambda)
      solution%openings = 0
      solution%openings(self%rows) = others%openings
      associate (tangents => self%tied_rows(self%n_tied_contacts + 1:self%n_tied))
        solution%openings(tangents) = -origins(tangents)
      end associate
      solution%states = contact_sticks
      solution%states(self%contacts) = others%states
      ! the sum of one term has no rounding
      do i = 1, size(self%anchors)
        associate (anchor => self%anchors(i))
          if (anchor > 0) solution%lambda(self%tied_rows(self%n_tied + i)) = &
            (solution%openings(anchor) - q(anchor)) / self%scales(i)
        end associate
      end do
    else
      call self%expand(0 * forces, others%lambda, solution%lambda)
      solution%lambda(:self%others%n_forces() + self%n_tied) = 0
      solution%openings = 0
      solution%states = contact_open
    end if
  end subroutine give_answer
end module sig_friction_ties
