! SPDX-License-Identifier: BSD-3-Clause
!> The full-order contact problem condensed to its contacts, as a kind of reduced model: it solves for the forces on all contacts,
!> without reconstruction, and needs no mesh. Where W and q come from is the matter of its compliance (sig_compliance).
!>
!> A query starts from the active set of the nearest training point.
module sig_condensed_model
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_condensed, answer_t, comparable_size, no_bound
  use sig_compliance, only: compliance_point_t, compliance_t
  use sig_contact_laws, only: contact_laws_t, laws_without_friction
  use sig_condensed_certificate, only: condensed_certificate_t
  use sig_dense_kernels, only: add_few_columns, add_product
  use sig_errors, only: error_t
  use sig_friction_changes, only: friction_changes_t
  use sig_friction_derivative, only: friction_derivative_t
  use sig_friction_steps, only: friction_memory_t, friction_steps_t
  use sig_free_motions, only: anchor_work, count_free_motions
  use sig_gradient, only: gradient_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_lcp_derivative, only: differentiate_lcp, lcp_derivative_t
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t, solve_lcp
  use sig_linear_algebra, only: multiply, unit_vector
  use sig_model_data, only: model_sizes_t
  use sig_reasons, only: reason_converged, reason_no_friction, reason_no_material, reason_outside, reason_outside_friction, &
    reason_pulled_off, reason_ray
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_text, only: fine_digits, short_number
  implicit none(type, external)
  private
  public :: condensed_model_t

  !> reasons why differentiate_lcp finds no derivatives
  character(*), parameter :: not_unique = 'the contact forces have no derivative at this point: they ' // &
    'are not unique, or contacts that touch without a force leave no solution beside this point'
  character(*), parameter :: with_friction = 'derivatives of contact with friction, or of tied contacts, need the history'
  character(*), parameter :: not_followed = 'derivatives through a history with friction build on those of the times before, ' // &
    'which are missing: they were not asked for at each time from the first one on, or one of these times has none'
  character(*), parameter :: other_side = 'the derivatives at an earlier time of this history differ between both ' // &
    'directions, and were asked for in the other one'
  character(*), parameter :: at_border = 'the contact forces have no derivative at this point: beside it, a contact with ' // &
    'friction closes that touches without a force here, or a contact gets friction that does not slip here'
  character(*), parameter :: pushed = 'the contact forces have no derivative at this point: beside it, on the side of ' // &
    'this direction, the loads move a body that no contact force holds here'

  type, extends(reduced_t) :: condensed_model_t
    class(compliance_t), allocatable :: compliance
    !> friction and ties of the contacts; `complete` sets them
    type(contact_laws_t) :: laws
    !> with the matrix of a fixed W; not allocated where contacts only open and close
    type(friction_steps_t), allocatable, private :: steps
    type(condensed_certificate_t), allocatable, private :: certificate
  contains
    procedure :: kind => kind_of
    procedure :: complete
    procedure :: mismatch
    procedure :: prepare
    procedure :: take_laws
    procedure :: create_room
    procedure :: open_contacts
    procedure :: start_from_set
    procedure :: keep_factors
    procedure :: unknown_changes
    procedure :: take_openings
    procedure :: take_unknowns
    procedure :: openings_of_terms
    procedure :: opening_changes
    procedure :: forget
    procedure :: n_remembered
    procedure :: save_memory
    procedure :: restore_memory
    procedure :: solve
    procedure :: fill_multipliers
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: contact_rows
    procedure :: n_rows
    procedure :: n_modes
    procedure :: write
    procedure :: read
    procedure :: describe
    procedure :: is_exact
    procedure :: has_displacement
    procedure :: has_whole_field
    procedure :: displacement_source
    procedure :: energy
    procedure :: correct_forces
    procedure :: can_certify
    procedure :: certify
    procedure :: note_of_bounds
    procedure :: differentiate
    procedure :: displacement_changes
    procedure :: change_errors
    procedure :: size_of_forces
    procedure :: size_of_field
  end type condensed_model_t

  type, extends(room_t) :: condensed_room_t
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    !> W and q of the point
    type(compliance_point_t) :: point
    !> [length] w = W z + q, shape (n_unknowns)
    real(rk), allocatable :: opening(:)
    !> active set to start from, shape (n_unknowns); and the one that start_from_set gives
    logical, allocatable :: start(:)
    logical, allocatable :: given_start(:)
    !> of contacts with friction
    type(friction_memory_t) :: memory
    !> those of the point, where W depends on it
    type(friction_steps_t) :: steps
    type(friction_changes_t) :: changes
  end type condensed_room_t

contains

  pure function kind_of(self) result(name)
    class(condensed_model_t), intent(in) :: self
    character(:), allocatable :: name

    name = self%compliance%kind()
  end function kind_of

  !> Allocates each array that is not allocated, with size 0 or without values.
  pure subroutine complete(self, sizes)
    class(condensed_model_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call self%compliance%complete(sizes)
    self%laws = sizes%laws
    if (.not. allocated(self%laws%tangents)) self%laws = laws_without_friction(sizes%n_multipliers)
  end subroutine complete

  !> Returns the name of an array whose shape or values do not fit the model, one of them if there are several; empty when all fit.
  !> Requires: complete.
  pure function mismatch(self, sizes) result(name)
    class(condensed_model_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = self%compliance%mismatch(sizes)
    ! steps of friction need all of W
    if (.not. (sizes%laws%is_plain() .or. self%compliance%n_systems() == 1)) name = 'laws'
  end function mismatch

  !> Prepares the compliance and the certificate (can_certify says whether there are bounds). There are no errors: message stays
  !> unallocated.
  subroutine prepare(self, message)
    class(condensed_model_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    type(condensed_certificate_t), allocatable :: certificate

    call self%compliance%prepare()
    call remake_steps(self)
    allocate (certificate)
    call certificate%create(self%compliance)
    call move_alloc(certificate, self%certificate)
  end subroutine prepare

  !> Takes the laws of the contacts; prepare takes those that `complete` has set. Requires: the anchors of the compliance, and a
  !> fixed W.
  subroutine take_laws(self, laws)
    class(condensed_model_t), intent(inout) :: self
    type(contact_laws_t), intent(in) :: laws

    self%laws = laws
    call remake_steps(self)
  end subroutine take_laws

  !> Makes the steps for the laws of the model.
  subroutine remake_steps(self)
    class(condensed_model_t), intent(inout) :: self

    if (allocated(self%steps)) deallocate (self%steps)
    if (.not. self%laws%is_plain()) call create_steps(self%compliance, self%compliance%laws_of_unknowns(self%laws), self%steps)
  end subroutine remake_steps

  subroutine create_steps(compliance, laws, steps)
    class(compliance_t), target, intent(in) :: compliance
    type(contact_laws_t), intent(in) :: laws
    type(friction_steps_t), allocatable, intent(out) :: steps
    type(compliance_point_t), target :: point
    real(rk), pointer, contiguous :: matrix(:, :)

    allocate (steps)
    call steps%start(laws, compliance%anchors)
    if (.not. compliance%is_fixed()) return
    call compliance%create_point(point)
    matrix => compliance%matrix(point)
    call steps%create(laws, compliance%anchors, compliance%scale, matrix, .true.)
  end subroutine create_steps

  !> Makes the work arrays for one thread.
  subroutine create_room(self, room)
    class(condensed_model_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(condensed_room_t), allocatable :: own
    integer :: n

    n = self%n_rows()
    allocate (own)
    call self%compliance%create_point(own%point)
    allocate (own%opening(n), own%start(n))
    own%workspace%has_one_matrix = self%compliance%is_fixed()
    if (allocated(self%steps)) call own%memory%begin(self%steps)
    call move_alloc(own, room)
  end subroutine create_room

  !> Lets something else than the terms open the contacts, such as inelastic strains: solve adds these openings to q. Pivot
  !> transforms do not know of them. Requires: one system, no reference sets.
  subroutine open_contacts(self, room, openings)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room
    !> [length] shape (n_rows), 0 at anchors
    real(rk), intent(in) :: openings(:)

    select type (room)
    type is (condensed_room_t)
      room%point%other_opening = openings
    end select
  end subroutine open_contacts

  !> Gives the active set from which the next problems of all contacts start, such as that of an answer for nearly the same
  !> openings. With size 0 they start as they do by default. With friction it is not used: steps start from the states of the last
  !> time.
  pure subroutine start_from_set(self, room, is_active)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room
    !> shape (n_unknowns) or (0)
    logical, intent(in) :: is_active(:)

    select type (room)
    type is (condensed_room_t)
      room%given_start = is_active
    end select
  end subroutine start_from_set

  !> Keeps factors of W from one problem to the next, where W is fixed. The answers of a room then depend, by rounding, on those
  !> before, until forget.
  pure subroutine keep_factors(self, room)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room

    select type (room)
    type is (condensed_room_t)
      room%workspace%keeps_factors = room%workspace%has_one_matrix
    end select
  end subroutine keep_factors

  !> Computes by how much the unknowns of the last answer change where openings do, for small changes that change no state: with the
  !> closed rows A, W_AA z_A' + w_A' = 0. Where there is no derivative, is_known is false and the changes are 0.
  subroutine unknown_changes(self, room, answer, openings, changes, is_known)
    class(condensed_model_t), target, intent(in) :: self
    class(room_t), target, intent(inout) :: room
    type(answer_t), intent(in) :: answer
    !> [length] in each direction, shape (n_rows, n_directions)
    real(rk), contiguous, intent(in) :: openings(:, :)
    !> [force] same shape
    real(rk), contiguous, intent(out) :: changes(:, :)
    logical, intent(out) :: is_known

    changes = 0
    is_known = .false.
    select type (room)
    type is (condensed_room_t)
      if (allocated(self%steps)) then
        call step_changes(self%compliance, self%steps, room, answer, openings, changes, is_known)
      else
        call active_changes(self%compliance, room, answer%unknowns > 0, openings, changes, is_known)
      end if
    end select
  end subroutine unknown_changes

  subroutine active_changes(compliance, room, is_active, openings, changes, is_known)
    class(compliance_t), target, intent(in) :: compliance
    type(condensed_room_t), target, intent(inout) :: room
    logical, intent(in) :: is_active(:)
    real(rk), intent(in) :: openings(:, :)
    !> 0 on entry
    real(rk), intent(inout) :: changes(:, :)
    logical, intent(out) :: is_known
    real(rk), pointer, contiguous :: matrix(:, :)

    is_known = .true.
    if (.not. any(is_active)) return
    matrix => compliance%matrix(room%point)
    call room%workspace%factor_set(matrix, is_active)
    is_known = .not. room%workspace%is_singular
    if (is_known) call room%workspace%solve_for_set(openings, changes)
  end subroutine active_changes

  !> Takes w [length] of the last answer, shape (n_rows).
  pure subroutine take_openings(self, room, openings)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(in) :: room
    real(rk), intent(inout) :: openings(:)

    select type (room)
    type is (condensed_room_t)
      openings = room%opening
    end select
  end subroutine take_openings

  !> Takes an answer that was found without this problem, from what changes of other openings and of theta change. Requires: no
  !> friction, one system.
  subroutine take_unknowns(self, room, theta, unknowns, openings, answer)
    class(condensed_model_t), intent(in) :: self
    !> with other openings (open_contacts)
    class(room_t), intent(inout) :: room
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] and w [length], which solve the problem; shape (n_rows)
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(in) :: openings(:)
    type(answer_t), intent(inout) :: answer
    logical :: is_valid

    select type (room)
    type is (condensed_room_t)
      answer%reason = reason_no_material
      call self%compliance%evaluate(theta, room%point, is_valid)
      if (.not. is_valid) return
      room%point%opening = room%point%opening + room%point%other_opening
      room%opening = openings
      answer%unknowns = unknowns
      answer%method = answer_condensed
      answer%reason = reason_converged
      answer%residual = 0
      answer%n_solutions = 1
      call complete_answer(self%compliance, theta, room, answer)
    end select
  end subroutine take_unknowns

  !> Returns by how much each term opens each contact [length per unit of theta], shape (n_rows, n_terms). Requires: W is fixed.
  function openings_of_terms(self, room, n_terms) result(openings)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(in) :: room
    integer, intent(in) :: n_terms
    real(rk), allocatable :: openings(:, :)
    real(rk) :: nothing(self%n_rows()), zeros(n_terms)
    integer :: i

    allocate (openings(self%n_rows(), n_terms), source=0.0_rk)
    nothing = 0
    zeros = 0
    select type (room)
    type is (condensed_room_t)
      do i = 1, n_terms
        call self%compliance%change_openings(room%point, zeros, unit_vector(n_terms, i), nothing, openings(:, i))
      end do
    end select
  end function openings_of_terms

  !> Computes changes of w [length] from changes of q and of the unknowns, shapes (n_rows, n_directions): w stays 0 in the rows that
  !> are closed, and the unknowns 0 in the others.
  subroutine opening_changes(self, room, is_closed, unknown_changes, changes)
    class(condensed_model_t), target, intent(in) :: self
    class(room_t), target, intent(in) :: room
    !> shape (n_rows)
    logical, intent(in) :: is_closed(:)
    real(rk), contiguous, intent(in) :: unknown_changes(:, :)
    !> on entry those of q
    real(rk), contiguous, intent(inout) :: changes(:, :)
    real(rk), pointer, contiguous :: matrix(:, :)
    integer :: i

    select type (room)
    type is (condensed_room_t)
      matrix => self%compliance%matrix(room%point)
      associate (rows => [(i, i=1, size(is_closed))])
        call change_open_rows(matrix, pack(rows, .not. is_closed), pack(rows, is_closed), unknown_changes, changes)
      end associate
    end select
  end subroutine opening_changes

  subroutine change_open_rows(matrix, open_rows, closed_rows, unknown_changes, changes)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    integer, intent(in) :: open_rows(:)
    integer, intent(in) :: closed_rows(:)
    real(rk), intent(in) :: unknown_changes(:, :)
    real(rk), intent(inout) :: changes(:, :)
    real(rk) :: block(size(open_rows), size(closed_rows)), of_closed(size(closed_rows), size(changes, 2)), &
      of_open(size(open_rows), size(changes, 2))

    block = matrix(open_rows, closed_rows)
    of_closed = unknown_changes(closed_rows, :)
    of_open = changes(open_rows, :)
    call add_product(1.0_rk, block, of_closed, of_open)
    changes = 0
    changes(open_rows, :) = of_open
  end subroutine change_open_rows

  subroutine step_changes(compliance, steps, room, answer, openings, changes, is_known)
    class(compliance_t), intent(in) :: compliance
    type(friction_steps_t), target, intent(in) :: steps
    type(condensed_room_t), target, intent(in) :: room
    type(answer_t), intent(in) :: answer
    real(rk), intent(in) :: openings(:, :)
    real(rk), intent(inout) :: changes(:, :)
    logical, intent(out) :: is_known
    type(friction_steps_t), pointer :: now
    type(friction_derivative_t) :: derivative
    real(rk) :: friction(steps%laws%n_contacts, size(openings, 2)), origins(steps%n_unknowns(), size(openings, 2))
    integer :: i

    friction = 0
    origins = 0
    now => steps
    if (.not. compliance%is_fixed()) now => room%steps
    call now%differentiate(room%memory, compliance%opening_terms(answer%theta, room%point), steps%laws%friction_at(answer%theta), &
      openings, friction, origins, derivative)
    is_known = .not. (derivative%is_singular .or. any(derivative%is_undecided))
    if (.not. is_known) return
    changes = derivative%forces(:size(changes, 1), :)
    do i = 1, size(compliance%anchors)
      changes(compliance%anchors(i), :) = derivative%forces(size(changes, 1) + i, :)
    end do
  end subroutine step_changes

  !> Begins a history: nothing has slipped yet.
  subroutine forget(self, room)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room

    select type (room)
    type is (condensed_room_t)
      call room%workspace%forget_sets()
      if (.not. allocated(self%steps)) return
      call room%memory%begin(self%steps)
      call room%changes%begin()
    end select
  end subroutine forget

  !> Returns the number of numbers that a step with friction depends on. Arguments of this and the next two: sig_reduced.
  pure integer function n_remembered(self)
    class(condensed_model_t), intent(in) :: self

    n_remembered = 0
    if (self%laws%remembers() .and. allocated(self%steps)) n_remembered = self%steps%n_remembered()
  end function n_remembered

  subroutine save_memory(self, room, numbers)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(in) :: room
    real(rk), intent(inout) :: numbers(:)

    if (size(numbers) == 0) return
    select type (room)
    type is (condensed_room_t)
      call room%memory%save(numbers)
    end select
  end subroutine save_memory

  subroutine restore_memory(self, room, numbers, is_valid)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room
    real(rk), intent(in) :: numbers(:)
    logical, intent(out) :: is_valid

    is_valid = .true.
    if (size(numbers) == 0) return
    select type (room)
    type is (condensed_room_t)
      call room%memory%restore(self%steps, numbers, is_valid)
      call room%changes%begin()
    end select
  end subroutine restore_memory

  !> Solves the complementarity problem of all contacts; with friction, the next step of the history in the room. Arguments:
  !> solve_at in sig_reduced; there is one solution, and no judge is asked.
  subroutine solve(self, theta, near, room, answer, judge)
    class(condensed_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    class(reduced_t), intent(in), optional :: judge

    select type (room)
    type is (condensed_room_t)
      if (allocated(self%steps)) then
        call solve_step(self%compliance, self%laws, self%steps, theta, room, answer)
      else
        call try_systems(self%compliance, theta, near, room, answer)
      end if
    end select
  end subroutine solve

  !> Solves the next step of the history in the room. Without an answer the reason is that of solve_friction, or
  !> reason_outside_friction where contacts that are no unknowns break their laws.
  subroutine solve_step(compliance, laws, steps, theta, room, answer)
    class(compliance_t), target, intent(in) :: compliance
    !> of all contacts
    type(contact_laws_t), intent(in) :: laws
    !> of those whose forces are unknowns
    type(friction_steps_t), target, intent(in) :: steps
    real(rk), contiguous, intent(in) :: theta(:)
    type(condensed_room_t), target, intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    real(rk), pointer, contiguous :: matrix(:, :)
    type(friction_steps_t), pointer :: now
    logical :: is_valid

    answer%reason = reason_no_material
    if (laws%has_negative_friction(theta)) then
      answer%reason = reason_no_friction
      return
    end if
    call compliance%evaluate(theta, room%point, is_valid)
    if (.not. is_valid) return
    if (allocated(room%point%other_opening)) room%point%opening = room%point%opening + room%point%other_opening
    if (laws%remembers()) then
      call room%changes%advance()
    else
      call room%changes%begin()
    end if
    matrix => compliance%matrix(room%point)
    now => steps
    if (.not. compliance%is_fixed()) then
      now => room%steps
      call now%create(steps%laws, compliance%anchors, compliance%scale, matrix, .false.)
    end if
    call now%advance(room%point%opening, steps%laws%friction_at(theta), room%memory)
    associate (solution => room%memory%solution, n => size(room%point%opening))
      answer%reason = solution%reason
      answer%method = answer_condensed
      answer%n_iterations = solution%n_steps
      answer%residual = solution%residual
      answer%n_solutions = merge(1, 0, solution%reason > 0)
      if (answer%reason <= 0) return
      answer%multipliers(:n) = solution%lambda(:n)
      if (laws%remembers()) then
        call answer%reserve_slips(laws%n_contacts)
        answer%slip(:n) = room%memory%slip
        answer%slips(:steps%laws%n_contacts) = steps%slipping(room%memory)
      end if
      call steps%fill_unknowns(room%memory, answer%unknowns(:n))
      room%opening = room%point%opening
      call add_few_columns(matrix, answer%unknowns(:n), room%opening)
    end associate
    call compliance%expand_step(theta, room%point, answer, is_valid)
    if (.not. is_valid) then
      answer%reason = reason_outside_friction
      answer%n_solutions = 0
      return
    end if
    call count_free(matrix, compliance, answer)
    call answer%take_all_forces()
    ! contacts are closed, and not their tangential forces
    answer%is_active(:laws%n_contacts) = laws%are_closed(answer%multipliers)
    answer%is_active(laws%n_contacts + 1:) = .false.
    call compliance%solve_modes(room%point, answer)
  end subroutine solve_step

  !> Tries the systems of the compliance one after the other, until one gives an answer.
  subroutine try_systems(compliance, theta, near, room, answer)
    class(compliance_t), intent(in) :: compliance
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    integer :: first, i

    answer%n_iterations = 0
    first = compliance%first_system(near%nearest)
    do i = 0, compliance%n_systems() - 1
      room%point%i_system = modulo(first - 1 + i, compliance%n_systems()) + 1
      call solve_system(compliance, theta, near, room, answer)
      if (answer%reason > 0) return
    end do
  end subroutine try_systems

  !> Solves a system, and sets the forces of all rows. Without an answer the reason is that of solve_lcp, reason_no_material for
  !> impossible elastic constants, or reason_outside where rows that are no unknowns have the wrong sign; in a problem with anchors
  !> reason_ray becomes reason_pulled_off.
  subroutine solve_system(compliance, theta, near, room, answer)
    class(compliance_t), target, intent(in) :: compliance
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    type(condensed_room_t), target, intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    real(rk), pointer, contiguous :: matrix(:, :)
    logical :: is_valid

    answer%reason = reason_no_material
    call compliance%evaluate(theta, room%point, is_valid)
    if (.not. is_valid) return
    if (allocated(room%point%other_opening)) room%point%opening = room%point%opening + room%point%other_opening
    matrix => compliance%matrix(room%point)
    call find_unknowns(compliance, matrix, theta, near, room, answer)
    if (answer%reason == reason_ray .and. size(compliance%anchors) > 0) answer%reason = reason_pulled_off
    if (answer%reason > 0) call complete_answer(compliance, theta, room, answer)
  end subroutine solve_system

  !> Sets the forces of all rows, and what follows from them, for unknowns and openings that solve the problem of the point. Without
  !> an answer the reason is reason_outside (solve_system).
  subroutine complete_answer(compliance, theta, room, answer)
    class(compliance_t), target, intent(in) :: compliance
    real(rk), contiguous, intent(in) :: theta(:)
    !> in: openings
    type(condensed_room_t), target, intent(inout) :: room
    !> in: unknowns
    type(answer_t), intent(inout) :: answer
    real(rk), pointer, contiguous :: matrix(:, :)
    logical :: is_valid
    integer :: n

    n = size(room%opening)
    call compliance%expand(room%point, room%opening, answer%unknowns(:n), answer%multipliers, is_valid)
    if (.not. is_valid) then
      answer%reason = reason_outside
      answer%n_solutions = 0
      return
    end if
    matrix => compliance%matrix(room%point)
    call compliance%drop_rounding(theta, room%point, answer%unknowns(:n), answer%multipliers)
    call count_free(matrix, compliance, answer)
    call answer%take_all_forces()
    call compliance%solve_modes(room%point, answer)
  end subroutine complete_answer

  !> Solves for the unknowns by what is known of the nearest training point (solve_near), and with all of W if that gives no answer.
  subroutine find_unknowns(compliance, matrix, theta, near, room, answer)
    class(compliance_t), intent(in) :: compliance
    !> [length/force] W
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    !> with q in room%point
    type(condensed_room_t), intent(inout) :: room
    !> out: reason and unknowns; with a reason > 0, w is in room%opening
    type(answer_t), intent(inout) :: answer
    logical :: is_tried

    answer%reason = reason_ray
    call compliance%start_from(near%nearest, room%point, room%start)
    if (allocated(room%given_start)) then
      if (size(room%given_start) == size(room%start)) room%start = room%given_start
    end if
    call compliance%solve_near(near%nearest, theta, room%start, room%point, room%solution, room%workspace, answer%unknowns, &
      is_tried)
    if (is_tried) call answer%take_solution(room%solution, answer_condensed)
    room%opening = room%point%opening
    if (answer%reason > 0) then
      call add_few_columns(matrix, answer%unknowns(:size(room%opening)), room%opening)
      return
    end if
    call solve_lcp(matrix, room%point%opening, room%start, room%solution, room%workspace)
    call answer%take_solution(room%solution, answer_condensed)
    answer%unknowns(:size(room%start)) = room%solution%lambda
    if (any(room%solution%is_active)) room%opening = room%workspace%w(:size(room%start))
  end subroutine find_unknowns

  !> Counts the motions that no force holds (n_free_motions).
  subroutine count_free(matrix, compliance, answer)
    !> [length/force] W
    real(rk), contiguous, intent(in) :: matrix(:, :)
    class(compliance_t), intent(in) :: compliance
    !> in: multipliers, 0 where they are only rounding
    type(answer_t), intent(inout) :: answer

    answer%n_free_motions = 0
    if (size(compliance%anchors) == 0) return
    answer%n_free_motions = count_free_motions(anchor_work(matrix, compliance%anchors, compliance%scale), &
      abs(answer%multipliers))
  end subroutine count_free

  !> Copies the forces of all contacts from the answer, which has them already; `room` is not used.
  subroutine fill_multipliers(self, answer, room, multipliers)
    class(condensed_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    class(room_t), intent(inout) :: room
    real(rk), intent(out) :: multipliers(:)

    multipliers = answer%multipliers
  end subroutine fill_multipliers

  !> Computes the displacement [length] of all dofs, shape (n_dofs); it is NaN for dofs of which there is none.
  subroutine fill_displacement(self, answer, displacement)
    class(condensed_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    call self%compliance%fill_displacement(answer, displacement)
  end subroutine fill_displacement

  !> Returns the displacement [length] of one dof, 1-based; NaN if there is none of this dof.
  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(condensed_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = self%compliance%displacement_of_dof(answer, dof)
  end function displacement_of_dof

  !> Returns the numbers 1, 2, ..., n_rows: the part gives the forces of all contact rows of the model.
  pure function contact_rows(self) result(numbers)
    class(condensed_model_t), intent(in) :: self
    integer, allocatable :: numbers(:)
    integer :: i

    numbers = [(i, i=1, self%n_rows())]
  end function contact_rows

  pure integer function n_rows(self)
    class(condensed_model_t), intent(in) :: self

    n_rows = self%compliance%n_rows()
  end function n_rows

  !> Returns the number of mode coordinates in an answer. Forces do not depend on them.
  pure integer function n_modes(self)
    class(condensed_model_t), intent(in) :: self

    n_modes = self%compliance%n_modes()
  end function n_modes

  !> Writes the part to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(condensed_model_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call self%compliance%write(file, group, length, force)
  end subroutine write

  !> Reads the part from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(condensed_model_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call self%compliance%read(file, group, error)
  end subroutine read

  pure function describe(self) result(text)
    class(condensed_model_t), intent(in) :: self
    character(:), allocatable :: text

    text = self%compliance%describe()
  end function describe

  !> Returns true: the forces are those of all contacts, without reconstruction.
  pure logical function is_exact(self)
    class(condensed_model_t), intent(in) :: self

    is_exact = .true.
  end function is_exact

  pure logical function has_displacement(self)
    class(condensed_model_t), intent(in) :: self

    has_displacement = self%compliance%has_displacement()
  end function has_displacement

  pure logical function has_whole_field(self, n_dofs)
    class(condensed_model_t), intent(in) :: self
    integer, intent(in) :: n_dofs

    has_whole_field = self%compliance%has_whole_field(n_dofs)
  end function has_whole_field

  pure integer function displacement_source(self, dof) result(source)
    class(condensed_model_t), intent(in) :: self
    integer, intent(in) :: dof

    source = self%compliance%displacement_source(dof)
  end function displacement_source

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length] of forces of all contacts, without the rows of anchors;
  !> huge for forces that do not balance the loads on bodies that only contact holds. Arguments: energy_unknown in sig_reduced.
  !> Requires: prepare.
  real(rk) function energy(self, theta, multipliers)
    class(condensed_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: multipliers(:)

    energy = self%certificate%energy(self%compliance, theta, multipliers)
  end function energy

  !> If only contact holds a body, removes forces on open contacts from `multipliers` and balances the others (correct of
  !> sig_condensed_certificate, which says when nothing changes). Otherwise it does nothing. Arguments: nothing_to_correct in
  !> sig_reduced. Requires: prepare.
  subroutine correct_forces(self, theta, room, multipliers)
    class(condensed_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    class(room_t), intent(inout) :: room
    real(rk), contiguous, intent(inout) :: multipliers(:)

    select type (room)
    type is (condensed_room_t)
      call self%certificate%correct(self%compliance, theta, room%point, room%opening, multipliers)
    end select
  end subroutine correct_forces

  !> Whether the part can bound errors.
  pure logical function can_certify(self)
    class(condensed_model_t), intent(in) :: self

    can_certify = .false.
    if (allocated(self%certificate)) can_certify = self%certificate%is_valid(self%compliance)
  end function can_certify

  !> Sets the bounds of the answer: of the error of `multipliers`, whichever part found them, and for own forces of the displacement
  !> (sig_condensed_certificate). Arguments: no_certificate in sig_reduced. Requires: can_certify; for own forces, that solve with
  !> this room found them last.
  subroutine certify(self, multipliers, is_own, room, answer)
    class(condensed_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    logical, intent(in) :: is_own
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    select type (room)
    type is (condensed_room_t)
      if (allocated(self%steps)) then
        associate (laws => self%steps%laws)
          call self%certificate%certify_step(self%compliance, laws, self%steps%contraction(laws%friction_at(answer%theta)), &
            room%memory, room%point, room%opening, answer)
        end associate
      else if (is_own) then
        call self%certificate%certify_own(self%compliance, multipliers, room%point, room%opening, answer)
      else
        call self%certificate%certify_foreign(self%compliance, multipliers, room%point, room%opening, answer)
      end if
    end select
  end subroutine certify

  !> Says up to which coefficients of friction there are bounds, and what stands in their place above. Requires: prepare.
  pure function note_of_bounds(self) result(note)
    class(condensed_model_t), intent(in) :: self
    character(:), allocatable :: note

    note = ''
    if (.not. (allocated(self%steps) .and. self%can_certify())) return
    if (.not. self%laws%remembers()) return
    note = 'error_bound is a backward error of each step'
    associate (friction => self%steps%bounded_friction())
      if (friction > 0) note = note // ', and a bound of its error where all coefficients of friction are below ' // &
        short_number(friction, fine_digits)
    end associate
  end function note_of_bounds

  !> Computes the derivatives of the unknowns and of the multipliers with respect to each parameter. Errors: message is allocated if
  !> the contact forces are not unique, the loads move a body that no contact force holds, or the problem of the contacts that graze
  !> has no solution (differentiate_lcp). With friction it is, too, without the room, if the derivatives of the earlier times of the
  !> history are not known, or if a contact is at a border of two states where there is no derivative (sig_friction_derivative).
  !> Arguments: no_derivative in sig_reduced.
  subroutine differentiate(self, answer, gradient, message, room)
    class(condensed_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    class(room_t), intent(inout), optional :: room

    if (.not. allocated(self%steps)) then
      call differentiate_problem(self%compliance, answer, gradient, message)
    else if (.not. present(room)) then
      message = with_friction
    else
      select type (room)
      type is (condensed_room_t)
        call differentiate_step(self%compliance, self%steps, answer, room, gradient, message)
      end select
    end if
    if (.not. allocated(message)) call self%compliance%complete_gradient(answer, gradient)
  end subroutine differentiate

  !> Computes the derivatives of the last step of the history in the room, and keeps them there for the next one.
  subroutine differentiate_step(compliance, steps, answer, room, gradient, message)
    class(compliance_t), intent(in) :: compliance
    type(friction_steps_t), target, intent(in) :: steps
    type(answer_t), intent(in) :: answer
    type(condensed_room_t), target, intent(inout) :: room
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    type(friction_steps_t), pointer :: now
    real(rk), allocatable :: changes(:, :), friction(:, :), origins(:, :)
    type(friction_derivative_t) :: derivative
    integer :: i

    if (.not. room%changes%are_known) then
      message = not_followed
    else if (.not. room%changes%fits(gradient%direction)) then
      message = other_side
    end if
    if (allocated(message)) return
    associate (n => size(room%point%opening), n_parameters => size(gradient%theta, 2), n_given => gradient%n_given)
      allocate (changes(n, n_parameters), friction(steps%laws%n_contacts, n_parameters))
      allocate (origins(steps%n_unknowns(), n_parameters), source=0.0_rk)
      do i = 1, n_parameters
        call compliance%change_openings(room%point, answer%theta, gradient%theta(:, i), answer%unknowns(:n), changes(:, i))
        friction(:, i) = steps%laws%friction_at(gradient%theta(:, i))
      end do
      ! the other values of a state are those of its time alone
      if (allocated(room%changes%origins)) then
        origins(:, :n_given) = room%changes%origins
        gradient%is_one_sided(:n_given) = gradient%is_one_sided(:n_given) .or. room%changes%is_one_sided
      end if
      now => steps
      if (.not. compliance%is_fixed()) now => room%steps
      call now%differentiate(room%memory, gradient%sizes(compliance%opening_terms(answer%theta, room%point), changes), &
        steps%laws%friction_at(answer%theta), gradient%direction * changes, gradient%direction * friction, &
        gradient%direction * origins, derivative)
      if (derivative%is_singular) then
        message = not_unique
      else if (any(derivative%is_undecided)) then
        message = at_border
      end if
      ! the next time needs derivatives over what is the same at all times
      if (derivative%is_singular .or. any(derivative%is_undecided(:n_given))) return
      call gradient%take_step(derivative, compliance%anchors)
      call compliance%expand_changes(room%point, gradient)
      call room%changes%keep(origins(:, :n_given) - gradient%direction * derivative%openings(:, :n_given), &
        gradient%is_one_sided(:n_given), gradient%direction)
    end associate
  end subroutine differentiate_step

  subroutine differentiate_problem(compliance, answer, gradient, message)
    class(compliance_t), target, intent(in) :: compliance
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    type(compliance_point_t), target :: point
    real(rk), pointer, contiguous :: matrix(:, :)
    real(rk), allocatable :: changes(:, :), sizes(:)
    type(lcp_derivative_t) :: derivative
    integer :: i, n
    logical :: is_possible

    call compliance%create_point(point)
    point%i_system = max(1, answer%row_cluster)
    call compliance%evaluate(answer%theta, point, is_possible)
    n = size(point%opening)
    allocate (changes(n, size(gradient%theta, 2)))
    do i = 1, size(changes, 2)
      call compliance%change_openings(point, answer%theta, gradient%theta(:, i), answer%unknowns(:n), changes(:, i))
    end do
    changes = gradient%direction * changes
    sizes = gradient%sizes(compliance%opening_terms(answer%theta, point), changes)
    matrix => compliance%matrix(point)
    call differentiate_lcp(matrix, point%opening, sizes, answer%unknowns(:n), changes, derivative, compliance%anchors)
    if (derivative%is_pushed) then
      message = pushed
    else if (derivative%is_singular) then
      message = not_unique
    else
      call gradient%take_forces(derivative, compliance%anchors, compliance%scale)
      call gradient%find_loose(matrix, compliance%anchors, compliance%scale, sizes, answer%unknowns(:n), answer%multipliers)
      call compliance%expand_changes(point, gradient)
    end if
  end subroutine differentiate_problem

  !> Computes the derivatives of the displacement of the given dofs with respect to one parameter; NaN for dofs of which there is no
  !> displacement, and for those that move in a motion that no contact force holds. Arguments: no_changes in sig_reduced.
  subroutine displacement_changes(self, answer, gradient, i_parameter, dofs, changes)
    class(condensed_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    integer :: i

    call self%compliance%change_field(answer, gradient, i_parameter, dofs, changes)
    do i = 1, size(dofs)
      if (gradient%is_loose(i_parameter, self%compliance%anchor_motion(dofs(i)))) changes(i) = ieee_value(1.0_rk, ieee_quiet_nan)
    end do
  end subroutine displacement_changes

  !> Returns the errors of the displacement's derivatives: those of modes or compressed responses under the changes of the forces,
  !> or of interpolation (bound_change), and rounding. Arguments: no_change_errors in sig_reduced.
  function change_errors(self, answer, gradient) result(errors)
    class(condensed_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    real(rk), allocatable :: errors(:)
    type(compliance_point_t) :: point
    real(rk) :: bound, size_of_change
    integer :: i
    logical :: is_possible

    allocate (errors(size(gradient%theta, 2)), source=no_bound)
    if (.not. self%has_displacement()) return
    call self%compliance%create_point(point)
    point%i_system = max(1, answer%row_cluster)
    call self%compliance%evaluate(answer%theta, point, is_possible)
    do i = 1, size(errors)
      if (self%compliance%has_linear_field()) then
        errors(i) = change_error(self%compliance, point, gradient%theta(:, i), &
          self%compliance%with_closed_anchors(gradient%unknowns(:, i)), gradient%lengths(i))
      else
        call self%compliance%bound_change(answer, gradient, i, point, bound, size_of_change)
        if (bound >= 0) errors(i) = relative_change(self%compliance, gradient%lengths(i), bound, size_of_change)
      end if
    end do
  end function change_errors

  real(rk) function change_error(compliance, point, theta_change, unknown_change, length) result(error)
    class(compliance_t), intent(in) :: compliance
    type(compliance_point_t), intent(in) :: point
    !> changes per unit of the parameter; unknowns: zero at anchors
    real(rk), contiguous, intent(in) :: theta_change(:)
    real(rk), contiguous, intent(in) :: unknown_change(:)
    !> [unit of the parameter] length of its range
    real(rk), intent(in) :: length
    real(rk) :: energy

    energy = size_in_energy(compliance, point, unknown_change)**2
    error = relative_change(compliance, length, compliance%field_error(theta_change, unknown_change, energy, point), &
      compliance%size_of_field(theta_change, unknown_change, energy, point))
  end function change_error

  !> Returns the bound of a derivative's error, relative to the size of the derivative, and rounding.
  real(rk) function relative_change(compliance, length, bound, size_of_change) result(error)
    class(compliance_t), intent(in) :: compliance
    !> [unit of the parameter] length of its range
    real(rk), intent(in) :: length
    !> [sqrt(force*length) per unit of the parameter]
    real(rk), intent(in) :: bound
    real(rk), intent(in) :: size_of_change
    real(rk) :: comparable

    comparable = comparable_size(length * size_of_change, compliance%largest_field)
    error = compliance%rounding()
    if (comparable > 0) error = error + length * bound / comparable
  end function relative_change

  !> Returns the size sqrt(lambda' W lambda) [sqrt(force*length)] of forces, with closed anchors: forces on anchors do not count. W
  !> is that of the point that `solve` left in the room.
  real(rk) function size_of_forces(self, room, multipliers)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(in) :: room
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)

    size_of_forces = 0
    select type (room)
    type is (condensed_room_t)
      size_of_forces = size_in_energy(self%compliance, room%point, self%compliance%with_closed_anchors(multipliers))
    end select
  end function size_of_forces

  !> Returns the size |u|_K [sqrt(force*length)] of the displacement in the norm of the stiffness, under unknowns z with closed
  !> anchors. W is that of the point that `solve` left in the room.
  real(rk) function size_of_field(self, room, theta, unknowns)
    class(condensed_model_t), intent(in) :: self
    class(room_t), intent(in) :: room
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] shape (n_multipliers); values on anchors do not count
    real(rk), contiguous, intent(in) :: unknowns(:)

    size_of_field = 0
    select type (room)
    type is (condensed_room_t)
      size_of_field = self%compliance%size_of_field(theta, self%compliance%with_closed_anchors(unknowns), &
        self%size_of_forces(room, unknowns)**2, room%point)
    end select
  end function size_of_field

  real(rk) function size_in_energy(compliance, point, forces)
    class(compliance_t), target, intent(in) :: compliance
    type(compliance_point_t), target, intent(in) :: point
    !> [force] zero at anchors
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk), pointer, contiguous :: matrix(:, :)
    real(rk) :: closing(size(forces))

    matrix => compliance%matrix(point)
    call multiply(1.0_rk, matrix, forces, 0.0_rk, closing)
    size_in_energy = sqrt(max(0.0_rk, dot_product(forces, closing)))
  end function size_in_energy
end module sig_condensed_model
