! SPDX-License-Identifier: BSD-3-Clause
!> Steps of a history of contact with friction, or with tied contacts, condensed to the forces.
!>
!> W and q have the form of sig_condensed: for an anchor, which holds a body that only contact holds, the unknown is its opening.
!> Here anchors keep their forces as unknowns, and the motions of these bodies are further unknowns (sig_friction_types). Tied
!> contacts are left out of the problem that is solved, wherever that loses no digits (sig_friction_ties).
module sig_friction_steps
  use sig_contact_laws, only: contact_laws_t
  use sig_friction_contraction, only: unit_contraction
  use sig_friction_derivative, only: differentiate_friction, friction_derivative_t, friction_step_t
  use sig_friction_problem, only: check_forces, contact_open, contact_slips, contact_sticks, count_solutions, &
                                  friction_contacts_t, friction_solution_t, friction_workspace_t
  use sig_friction_search, only: friction_loads_t, search_friction
  use sig_friction_ties, only: friction_ties_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert
  use sig_reasons, only: reason_converged
  implicit none(type, external)
  private
  public :: friction_steps_t, friction_memory_t

  !> What a step problem has at all times.
  type :: friction_steps_t
    type(contact_laws_t) :: laws
    !> contacts of the laws, and motions
    type(friction_contacts_t), private :: contacts
    !> rows of anchors, 1-based; each has a motion
    integer, allocatable, private :: anchors(:)
    !> [length/force] shape (n, n) with n = n_rows + n_motions
    real(rk), allocatable, private :: compliance(:, :)
    type(friction_ties_t), private :: ties
    !> of the matrix of the problem that is solved, or nothing where it has none, as in corners
    real(rk), allocatable, private :: inverse(:, :)
    !> [-] unit_contraction; huge where it is not known
    real(rk), private :: unit_contraction = huge(1.0_rk)
  contains
    procedure :: start
    procedure :: create
    procedure :: advance
    procedure :: contraction
    procedure :: bounded_friction
    procedure :: count_answers
    procedure :: differentiate
    procedure :: fill_unknowns
    procedure :: motion
    procedure :: n_remembered
    procedure :: n_unknowns
    procedure :: slipping
  end type friction_steps_t

  !> What is carried from one time to the next, and the answer at the present time.
  type :: friction_memory_t
    !> forces, openings and states; its reason is reason_converged where there is an answer
    type(friction_solution_t) :: solution
    !> [length] places of tangential rows from which slips of the present step count; shape (n_rows + n_motions)
    real(rk), allocatable :: origins(:)
    !> [length] slip of the present step in tangential rows; 0 where a contact sticks, opens or is open; shape (n_rows)
    real(rk), allocatable :: slip(:)
    !> of the problem that is solved
    type(friction_loads_t), private :: loads
    type(friction_workspace_t), private :: workspace
    !> the answer without tied contacts, where these are left out
    type(friction_solution_t), private :: others
    !> [length] q with rows of motions, shape (n_rows + n_motions)
    real(rk), allocatable, private :: openings(:)
    !> whether a step was made since the beginning of the history
    logical, private :: has_begun = .false.
  contains
    procedure :: begin
    procedure :: is_open
    procedure :: n_operations
    procedure :: change_to_exact
    procedure :: save
    procedure :: restore
  end type friction_memory_t

contains

  !> Takes the contacts and their laws; enough for memory%begin.
  subroutine start(self, laws, anchors)
    class(friction_steps_t), intent(inout) :: self
    type(contact_laws_t), intent(in) :: laws
    !> rows, 1-based
    integer, intent(in) :: anchors(:)

    self%laws = laws
    self%contacts = laws%friction_contacts_t
    self%contacts%n_motions = size(anchors)
    self%anchors = anchors
  end subroutine start

  !> Makes the matrix of the steps from W. A matrix of the same size, from a call before, is written over.
  subroutine create(self, laws, anchors, scale, compliance, keeps_inverse)
    class(friction_steps_t), intent(inout) :: self
    type(contact_laws_t), intent(in) :: laws
    !> rows, 1-based
    integer, intent(in) :: anchors(:)
    !> [length/force] the scale of the anchors
    real(rk), intent(in) :: scale
    !> [length/force] W; rows and columns of anchors are those of their openings; shape (n_rows, n_rows)
    real(rk), intent(in) :: compliance(:, :)
    !> whether the inverse is made, too, which pays if W is that of many steps
    logical, intent(in) :: keeps_inverse
    integer :: j, n

    call self%start(laws, anchors)
    n = size(compliance, 1)
    if (allocated(self%compliance)) then
      if (size(self%compliance, 1) /= self%contacts%n_rows()) deallocate (self%compliance)
    end if
    if (.not. allocated(self%compliance)) allocate (self%compliance(self%contacts%n_rows(), self%contacts%n_rows()))
    self%compliance(:n, :n) = compliance
    self%compliance(anchors, :) = 0
    self%compliance(:, anchors) = 0
    self%compliance(:n, n + 1:) = compliance(:, anchors)
    self%compliance(n + 1:, n + 1:) = 0
    ! a motion opens its own anchor, and no other
    do j = 1, size(anchors)
      self%compliance(anchors, n + j) = 0
      self%compliance(anchors(j), n + j) = scale
    end do
    self%compliance(n + 1:, :n) = -transpose(self%compliance(:n, n + 1:))
    call self%ties%create(self%compliance, self%contacts)
    if (allocated(self%inverse)) deallocate (self%inverse)
    self%unit_contraction = huge(self%unit_contraction)
    if (.not. keeps_inverse) return
    if (self%ties%are_left_out) then
      call keep_inverse(self, self%ties%compliance, self%ties%others)
    else
      call keep_inverse(self, self%compliance, self%contacts)
    end if
  end subroutine create

  !> Computes the inverse of the matrix of the problem that is solved, and its unit_contraction: that of a bonded body is smaller.
  subroutine keep_inverse(self, matrix, contacts)
    type(friction_steps_t), intent(inout) :: self
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    logical :: is_singular

    allocate (self%inverse(size(matrix, 1), size(matrix, 1)))
    call invert(matrix, self%inverse, is_singular)
    if (is_singular) deallocate (self%inverse)
    if (allocated(self%inverse) .and. size(self%anchors) == 0) &
      self%unit_contraction = unit_contraction(matrix, self%inverse, contacts)
  end subroutine keep_inverse

  !> Returns the contraction kappa (sig_friction_contraction) for given coefficients of friction; huge where it is not known:
  !> without an inverse, or with bodies that only contact holds. It allocates nothing.
  pure real(rk) function contraction(self, friction)
    class(friction_steps_t), intent(in) :: self
    !> [-] shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    real(rk) :: largest
    integer :: k

    largest = 0
    do k = 1, self%contacts%n_contacts
      if (self%contacts%tangents(1, k) > 0 .and. .not. self%contacts%is_tied(k)) largest = max(largest, friction(k))
    end do
    contraction = huge(contraction)
    if (self%unit_contraction < huge(contraction)) contraction = largest * self%unit_contraction
  end function contraction

  !> Returns the coefficient of friction below which kappa is below 1 [-]; 0 where kappa is not known.
  pure real(rk) function bounded_friction(self)
    class(friction_steps_t), intent(in) :: self

    bounded_friction = 0
    if (self%unit_contraction < huge(bounded_friction)) bounded_friction = 1 / self%unit_contraction
  end function bounded_friction

  !> Begins a history: nothing has slipped, and tangential rows are at the place 0.
  pure subroutine begin(self, steps)
    class(friction_memory_t), intent(inout) :: self
    type(friction_steps_t), intent(in) :: steps

    call start_over(self, steps)
    call self%workspace%kept%forget()
  end subroutine begin

  !> Does what `begin` does, but for kept factors.
  pure subroutine start_over(self, steps)
    class(friction_memory_t), intent(inout) :: self
    type(friction_steps_t), intent(in) :: steps

    associate (n => steps%contacts%n_rows(), n_rows => steps%contacts%n_forces())
      if (allocated(self%origins)) then
        if (size(self%origins) /= n) deallocate (self%origins, self%openings, self%slip)
      end if
      if (.not. allocated(self%origins)) allocate (self%origins(n), self%openings(n), self%slip(n_rows))
    end associate
    self%origins = 0
    self%slip = 0
    self%has_begun = .false.
    self%solution%reason = -1
  end subroutine start_over

  !> Solves the next step. memory%solution%reason says whether there is an answer (solve_friction). Requires: begin, and an answer
  !> of the last step.
  subroutine advance(self, opening, friction, memory)
    class(friction_steps_t), intent(in) :: self
    !> [length] q, in rows of anchors their scaled forces, which are exactly zero where they are only rounding; shape (n_rows)
    real(rk), contiguous, intent(in) :: opening(:)
    !> [-] coefficient of friction of each contact
    real(rk), intent(in) :: friction(:)
    type(friction_memory_t), intent(inout) :: memory
    integer :: i, k

    associate (n => size(opening), openings => memory%openings)
      openings(:n) = opening
      openings(n + 1:) = opening(self%anchors)
      openings(self%anchors) = 0
    end associate
    if (memory%has_begun) memory%origins = -memory%solution%openings
    memory%has_begun = .true.
    if (self%ties%are_left_out) then
      call advance_others(self, friction, memory)
    else
      call advance_all(self, friction, memory)
    end if
    memory%slip = 0
    if (memory%solution%reason /= reason_converged) return
    do k = 1, self%contacts%n_contacts
      if (memory%solution%states(k) /= contact_slips) cycle
      do i = 1, self%contacts%n_tangents(k)
        associate (row => self%contacts%tangents(i, k))
          memory%slip(row) = -memory%solution%openings(row) - memory%origins(row)
        end associate
      end do
    end do
  end subroutine advance

  !> Solves a step for all contacts.
  subroutine advance_all(self, friction, memory)
    class(friction_steps_t), intent(in) :: self
    real(rk), intent(in) :: friction(:)
    type(friction_memory_t), intent(inout) :: memory

    call memory%loads%take(memory%openings, memory%origins, friction)
    call search_friction(self%compliance, self%contacts, memory%loads, memory%solution, memory%workspace, self%inverse)
  end subroutine advance_all

  !> Solves a step without the tied contacts, and checks the answer for all contacts.
  subroutine advance_others(self, friction, memory)
    class(friction_steps_t), intent(in) :: self
    real(rk), intent(in) :: friction(:)
    type(friction_memory_t), intent(inout) :: memory
    real(rk) :: forces(size(self%ties%tied_rows)), q(size(self%ties%rows))

    associate (ties => self%ties, solution => memory%solution, origins => memory%origins)
      call ties%reduce(memory%openings, origins, forces, q)
      call memory%loads%take(q, origins(ties%rows), friction(ties%contacts))
      call ties%take_answer(solution, memory%others)
      call search_friction(ties%compliance, ties%others, memory%loads, memory%others, memory%workspace, self%inverse)
      call ties%give_answer(memory%others, forces, memory%openings, origins, solution)
      if (solution%reason == reason_converged) &
        call check_forces(self%compliance, memory%openings, origins, friction, self%contacts, solution)
    end associate
  end subroutine advance_others

  !> Returns the number of solutions of the last step that two more starts find (count_solutions); 1 without friction. Requires: the
  !> last step has an answer.
  integer function count_answers(self, friction, memory) result(n)
    class(friction_steps_t), intent(in) :: self
    !> that of the last step
    real(rk), intent(in) :: friction(:)
    type(friction_memory_t), intent(inout) :: memory

    if (self%ties%are_left_out) then
      associate (ties => self%ties)
        call count_solutions(ties%compliance, friction(ties%contacts), ties%others, memory%others, memory%workspace, n)
      end associate
    else
      call count_solutions(self%compliance, friction, self%contacts, memory%solution, memory%workspace, n)
    end if
  end function count_answers

  !> Computes the derivatives of the answer of the last step in some directions; those of its openings count from the change of the
  !> origins. Requires: the last step has an answer.
  subroutine differentiate(self, memory, terms, friction, changes, friction_changes, origins, derivative)
    class(friction_steps_t), intent(in) :: self
    type(friction_memory_t), intent(in) :: memory
    !> [length] sizes of the terms of q, shape (n_rows)
    real(rk), intent(in) :: terms(:)
    !> that of the last step
    real(rk), intent(in) :: friction(:)
    !> [length] change of q, shape (n_rows, n_directions), and [-] of the coefficients, shape (n_contacts, n_directions)
    real(rk), intent(in) :: changes(:, :)
    real(rk), intent(in) :: friction_changes(:, :)
    !> [length] change of the origins, shape (n_unknowns, n_directions)
    real(rk), intent(in) :: origins(:, :)
    type(friction_derivative_t), intent(out) :: derivative
    type(friction_step_t) :: step
    real(rk) :: openings(size(origins, 1), size(origins, 2))

    associate (n => size(changes, 1), contacts => self%contacts)
      step%q = memory%openings
      step%origins = memory%origins
      step%terms = [terms, terms(self%anchors)]
      step%terms(self%anchors) = 0
      step%friction = merge(friction, 0.0_rk, self%laws%have_friction())
      openings(:n, :) = changes
      openings(n + 1:, :) = changes(self%anchors, :)
      openings(self%anchors, :) = 0
      openings(contacts%n_contacts + 1:n, :) = openings(contacts%n_contacts + 1:n, :) + origins(contacts%n_contacts + 1:n, :)
      call differentiate_friction(self%compliance, contacts, step, memory%solution, openings, friction_changes, derivative)
    end associate
  end subroutine differentiate

  !> Returns the number of forces and motions.
  pure integer function n_unknowns(self)
    class(friction_steps_t), intent(in) :: self

    n_unknowns = self%contacts%n_rows()
  end function n_unknowns

  !> Returns how many numbers `save` gives.
  pure integer function n_remembered(self)
    class(friction_steps_t), intent(in) :: self

    n_remembered = 1 + 2 * self%n_unknowns() + self%contacts%n_contacts + 3 + 5 * self%contacts%n_contacts
  end function n_remembered

  !> Sets the unknowns of sig_condensed [force]: forces, and in rows of anchors their scaled openings; shape (n_rows).
  pure subroutine fill_unknowns(self, memory, unknowns)
    class(friction_steps_t), intent(in) :: self
    type(friction_memory_t), intent(in) :: memory
    real(rk), intent(inout) :: unknowns(:)

    unknowns = memory%solution%lambda(:size(unknowns))
    unknowns(self%anchors) = memory%solution%lambda(size(unknowns) + 1:)
  end subroutine fill_unknowns

  !> Returns the scaled openings of the anchors: of the answer or, where there is no equilibrium, of the motion in which bodies
  !> slide or come off, up to a factor; shape (n_motions).
  pure function motion(self, memory) result(openings)
    class(friction_steps_t), intent(in) :: self
    type(friction_memory_t), intent(in) :: memory
    real(rk) :: openings(size(self%anchors))

    openings = memory%solution%lambda(size(memory%slip) + 1:)
  end function motion

  !> Returns which contacts slip; shape (n_contacts). Those without friction slip wherever they are closed. A contact with friction
  !> sticks where prescribed displacements leave it no direction to slip in.
  pure function slipping(self, memory)
    class(friction_steps_t), intent(in) :: self
    type(friction_memory_t), intent(in) :: memory
    logical :: slipping(self%contacts%n_contacts)

    slipping = memory%solution%states == contact_slips .and. &
               (self%laws%tangents(1, :) > 0 .or. .not. self%laws%friction_factors > 0)
  end function slipping

  !> Gives what the next step depends on: whether there was a step, then its forces, openings and states, and what its kept factors
  !> are computed from. Requires: begin, and an
  !> answer of the last step if there was one.
  pure subroutine save(self, numbers)
    class(friction_memory_t), intent(in) :: self
    !> shape (n_remembered)
    real(rk), intent(out) :: numbers(:)

    numbers = 0
    if (.not. self%has_begun) return
    numbers(1) = 1
    associate (n => size(self%origins))
      numbers(2:n + 1) = self%solution%lambda
      numbers(n + 2:2 * n + 1) = self%solution%openings
      associate (n_contacts => size(self%solution%states))
        ! kept factors are those of the contacts that are not left out
        if (self%workspace%kept%is_set) &
          call self%workspace%kept%save(numbers(2 * n + 2:2 * n + 4 + 5 * size(self%workspace%kept%states)))
        numbers(2 * n + 5 + 5 * n_contacts:) = self%solution%states
      end associate
    end associate
  end subroutine save

  !> Goes back to what `save` gave. is_valid: the numbers are such; otherwise this is `begin`.
  pure subroutine restore(self, steps, numbers, is_valid)
    class(friction_memory_t), intent(inout) :: self
    type(friction_steps_t), intent(in) :: steps
    !> shape (n_remembered)
    real(rk), intent(in) :: numbers(:)
    logical, intent(out) :: is_valid
    integer :: k

    call start_over(self, steps)
    is_valid = all(abs(numbers) <= huge(numbers)) .and. any(abs(numbers(1) - [0, 1]) <= 0)
    if (.not. (is_valid .and. numbers(1) > 0)) call self%workspace%kept%forget()
    if (.not. (is_valid .and. numbers(1) > 0)) return
    associate (n => size(self%origins), n_contacts => steps%contacts%n_contacts, &
      n_kept => merge(steps%ties%others%n_contacts, steps%contacts%n_contacts, steps%ties%are_left_out))
      do k = 2 * n + 5 + 5 * n_contacts, size(numbers)
        is_valid = is_valid .and. any(abs(numbers(k) - [contact_open, contact_sticks, contact_slips]) <= 0)
      end do
      if (is_valid) call self%workspace%kept%restore(numbers(2 * n + 2:2 * n + 4 + 5 * n_kept), is_valid)
      if (.not. is_valid) call self%workspace%kept%forget()
      if (.not. is_valid) return
      self%solution%lambda = numbers(2:n + 1)
      self%solution%openings = numbers(n + 2:2 * n + 1)
      self%solution%states = nint(numbers(2 * n + 5 + 5 * n_contacts:))
    end associate
    self%solution%reason = reason_converged
    self%has_begun = .true.
  end subroutine restore

  !> Returns the operations of all linear problems that this memory was used for [-], so far.
  pure real(rk) function n_operations(self)
    class(friction_memory_t), intent(in) :: self

    n_operations = self%workspace%kept%n_operations
  end function n_operations

  !> Returns which contacts are open; shape (n_contacts).
  pure function is_open(self)
    class(friction_memory_t), intent(in) :: self
    logical :: is_open(size(self%solution%states))

    is_open = self%solution%states == contact_open
  end function is_open

  !> Returns a change of the openings [length] for which the forces of the last step are exact, by the law of each contact alone:
  !> gaps of contacts with a force, overlaps of others; slips of contacts that stick, and of those that slip the part that is not
  !> along their force. Shape (n_rows).
  pure function change_to_exact(self, laws, opening) result(change)
    class(friction_memory_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    !> [length] w = W z + q, in rows of anchors their openings; shape (n_rows)
    real(rk), intent(in) :: opening(:)
    real(rk) :: change(size(opening)), force(2), slip(2)
    integer :: i, k

    change = 0
    do k = 1, laws%n_contacts
      associate (normal => self%solution%lambda(k))
        change(k) = merge(opening(k), min(opening(k), 0.0_rk), normal > 0 .or. laws%is_tied(k))
        if (.not. (normal > 0 .or. laws%is_tied(k))) cycle
      end associate
      force = laws%tangential(k, self%solution%lambda)
      slip = -laws%tangential(k, opening) - laws%tangential(k, self%origins)
      if (self%solution%states(k) == contact_slips .and. .not. laws%is_tied(k)) then
        if (any(abs(force) > 0)) then
          slip = slip - max(0.0_rk, dot_product(slip, force)) / dot_product(force, force) * force
        else
          ! nothing holds a contact that slips without friction
          slip = 0
        end if
      end if
      do i = 1, laws%n_tangents(k)
        change(laws%tangents(i, k)) = slip(i)
      end do
    end do
  end function change_to_exact
end module sig_friction_steps
