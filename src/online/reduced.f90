! SPDX-License-Identifier: BSD-3-Clause
!> The functions that every kind of reduced model has. A kind extends reduced_t in a file of its own and has a line in
!> sig_reduced_kinds; queries, files, descriptions and the C interface use nothing else.
module sig_reduced
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t, no_bound
  use sig_gradient, only: gradient_t
  use sig_kinds, only: rk
  use sig_model_data, only: model_data_t, model_sizes_t
  use sig_reasons, only: put_reason
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: reduced_t, room_t, part_t, model_sizes_t, neighbors_t

  !> source of the displacement of a dof; displacement_exact: without modes, under the contact forces of the answer
  integer, parameter, public :: displacement_none = 0, displacement_by_modes = 1, displacement_exact = 2

  !> The training points near a point, 1-based; 0 = none.
  type :: neighbors_t
    integer :: nearest = 0
    !> the nearest training point on the other side, where the part starts from two sides
    integer :: opposite = 0
  end type neighbors_t

  !> Work arrays that a part needs to answer: one per thread, so that parts never change while they answer.
  type, abstract :: room_t
    !> whether answers need inelastic strains at all integration points; the same over a history
    logical :: has_points = .true.
  end type room_t

  type, abstract, extends(model_data_t) :: reduced_t
  contains
    procedure(prepare_part), deferred :: prepare
    procedure(make_room), deferred :: create_room
    procedure(solve_at), deferred :: solve
    procedure(fill_forces), deferred :: fill_multipliers
    procedure(index_list), deferred :: contact_rows
    procedure(size_of), deferred :: n_modes
    procedure, non_overridable :: ask
    ! functions that a kind may offer in addition
    procedure :: cells => no_indices
    procedure :: interior_dofs => no_indices
    procedure :: training_points => no_indices
    procedure :: warnings => no_warnings
    procedure :: put_refusal => put_usual_refusal
    procedure :: is_exact => no
    procedure :: starts_from_two_sides => no
    procedure :: has_displacement => yes
    procedure :: displacement_source => by_modes
    procedure :: has_whole_field => whole
    procedure :: displace_under => nothing_to_do
    procedure :: remembers => no
    procedure :: begin_step => nothing_to_begin
    procedure :: forget => nothing_to_forget
    procedure :: n_remembered => nothing_remembered
    procedure :: n_flow_points => no_points
    procedure :: save_memory => nothing_to_save
    procedure :: restore_memory => nothing_to_restore
    procedure :: energy => energy_unknown
    procedure :: correct_forces => nothing_to_correct
    procedure :: can_certify => no
    procedure :: certify => no_certificate
    procedure :: note_of_bounds => nothing_to_say
    procedure :: differentiate => no_derivative
    procedure :: displacement_changes => no_changes
    procedure :: change_errors => no_change_errors
  end type reduced_t

  !> A part of a model, of any kind.
  type :: part_t
    class(reduced_t), allocatable :: reduced
  end type part_t

  abstract interface
    !> Computes everything that does not depend on the point. Errors: message is allocated when the part cannot answer. Requires:
    !> complete.
    subroutine prepare_part(self, message)
      import :: reduced_t
      implicit none(type, external)
      class(reduced_t), intent(inout) :: self
      character(:), allocatable, intent(out) :: message
    end subroutine prepare_part

    !> Makes the work arrays of the part for one thread. Requires: prepare.
    subroutine make_room(self, room)
      import :: reduced_t, room_t
      implicit none(type, external)
      class(reduced_t), intent(in) :: self
      class(room_t), allocatable, intent(out) :: room
    end subroutine make_room

    !> Answers at a point with given values of the terms. If there is no answer, answer%reason < 0 says why. The start depends on
    !> the point alone, so that an answer that is not unique does not depend on the query before.
    subroutine solve_at(self, theta, near, room, answer, judge)
      import :: answer_t, neighbors_t, reduced_t, rk, room_t
      implicit none(type, external)
      class(reduced_t), intent(in) :: self
      !> shape (n_terms)
      real(rk), contiguous, intent(in) :: theta(:)
      !> training points near the point
      type(neighbors_t), intent(in) :: near
      !> work arrays from create_room
      class(room_t), intent(inout) :: room
      !> in: after start; out: reason, method, multipliers and the values that belong to them
      type(answer_t), intent(inout) :: answer
      !> part of all contacts whose energy decides which of two solutions is better, in a kind that may find two
      class(reduced_t), intent(in), optional :: judge
    end subroutine solve_at

    !> Computes the forces of all contacts from an answer of this part.
    subroutine fill_forces(self, answer, room, multipliers)
      import :: answer_t, reduced_t, rk, room_t
      implicit none(type, external)
      class(reduced_t), intent(in) :: self
      type(answer_t), intent(in) :: answer
      !> work arrays from create_room
      class(room_t), intent(inout) :: room
      !> [force] >= 0, shape (n_multipliers)
      real(rk), intent(out) :: multipliers(:)
    end subroutine fill_forces

    !> Returns the contact rows whose forces the part gives without reconstruction, 1-based among those of the model.
    pure function index_list(self) result(numbers)
      import :: reduced_t
      implicit none(type, external)
      class(reduced_t), intent(in) :: self
      integer, allocatable :: numbers(:)
    end function index_list

    !> Returns the number of the mode coordinates in an answer of the part.
    pure integer function size_of(self)
      import :: reduced_t
      implicit none(type, external)
      class(reduced_t), intent(in) :: self
    end function size_of
  end interface

contains

  !> Answers at a point as training does, from the active set of a training point. Requires: is_exact.
  subroutine ask(self, theta, nearest, room, answer)
    class(reduced_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> number of the training point, 1-based
    integer, intent(in) :: nearest
    !> work arrays from create_room
    class(room_t), intent(inout) :: room
    !> answer%reason < 0 says why there is no answer
    type(answer_t), intent(inout) :: answer

    call answer%start(1, size(theta), self%n_modes(), self%n_rows(), self%n_rows())
    answer%theta = theta
    call self%solve(theta, neighbors_t(nearest=nearest), room, answer)
  end subroutine ask

  !> Returns an empty list. This is the default of three functions: `cells` (cells of the reduced integration domain),
  !> `interior_dofs` (dofs that have an equation), and `training_points` (training points whose snapshots a cluster has).
  pure function no_indices(self) result(numbers)
    class(reduced_t), intent(in) :: self
    integer, allocatable :: numbers(:)

    allocate (numbers(0))
  end function no_indices

  !> Returns the warnings of the training, one sentence each. This default has none.
  pure function no_warnings(self) result(warnings)
    class(reduced_t), intent(in) :: self
    type(string_t), allocatable :: warnings(:)

    allocate (warnings(0))
  end function no_warnings

  !> Writes why the answer is none, as a sentence without its full stop. This default says what the reason means. Safe for several
  !> threads.
  pure subroutine put_usual_refusal(self, answer, text)
    class(reduced_t), intent(in) :: self
    !> of this part, with reason <= 0
    type(answer_t), intent(in) :: answer
    !> length of at least reason_length
    character(*), intent(out) :: text

    call put_reason(answer%reason, text)
  end subroutine put_usual_refusal

  !> Returns false. This is the default of four functions: `is_exact` (the part solves for the forces of all contacts, without
  !> reconstruction), `starts_from_two_sides` (solve uses near%opposite), `can_certify` (certify may be called), and `remembers`
  !> (an answer depends on those before it in its history; the laws of contacts say this for friction).
  pure logical function no(self)
    class(reduced_t), intent(in) :: self

    no = .false.
  end function no

  !> Whether the part has a displacement, perhaps of some dofs only. This default says yes.
  pure logical function yes(self)
    class(reduced_t), intent(in) :: self

    yes = .true.
  end function yes

  !> Whether the part has a displacement of all dofs. This default says yes.
  pure logical function whole(self, n_dofs)
    class(reduced_t), intent(in) :: self
    !> number of dofs of the model
    integer, intent(in) :: n_dofs

    whole = .true.
  end function whole

  !> Returns the source of a dof's displacement, one of displacement_*. This default is displacement_by_modes for every dof.
  pure integer function by_modes(self, dof) result(source)
    class(reduced_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: dof

    source = displacement_by_modes
  end function by_modes

  !> Sets the coordinates of this part's modes, and the forces of its domain, in an answer. They become those under contact forces
  !> that another part found at the same point, so that this part can give the displacement. This default does nothing.
  subroutine nothing_to_do(self, room, answer)
    class(reduced_t), intent(in) :: self
    !> room of this part, after solve at this point
    class(room_t), intent(inout) :: room
    !> in: the multipliers of all contacts; out: coordinates, multipliers_rid and is_active
    type(answer_t), intent(inout) :: answer
  end subroutine nothing_to_do

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length] of contact forces lambda. Of all lambda >= 0, those of
  !> the full-order problem have the least energy. This default, for a kind without W, returns 0.
  real(rk) function energy_unknown(self, theta, multipliers) result(energy)
    class(reduced_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)

    energy = 0
  end function energy_unknown

  !> Begins a history: the next answer does not depend on those before. This default remembers nothing.
  subroutine nothing_to_forget(self, room)
    class(reduced_t), intent(in) :: self
    !> room of this part
    class(room_t), intent(inout) :: room
  end subroutine nothing_to_forget

  !> Takes what the next solve needs besides the terms. This default needs nothing.
  subroutine nothing_to_begin(self, room, state, dt)
    class(reduced_t), intent(in) :: self
    !> room of this part
    class(room_t), intent(inout) :: room
    !> numbers of the state: parameters, time, tables
    real(rk), intent(in) :: state(:)
    !> [time] since the last state of the history
    real(rk), intent(in) :: dt
  end subroutine nothing_to_begin

  !> Returns what users should know of the bounds of errors, a sentence; this default: nothing.
  pure function nothing_to_say(self) result(note)
    class(reduced_t), intent(in) :: self
    character(:), allocatable :: note

    note = ''
  end function nothing_to_say

  !> Returns how many numbers say what the next answer of a history depends on.
  pure integer function nothing_remembered(self) result(n)
    class(reduced_t), intent(in) :: self

    n = 0
  end function nothing_remembered

  !> Returns at how many integration points an answer has plastic strains and creep strains.
  pure integer function no_points(self) result(n)
    class(reduced_t), intent(in) :: self

    n = 0
  end function no_points

  !> Gives these numbers. Requires: the last time of the history, if there is one, has an answer.
  subroutine nothing_to_save(self, room, numbers)
    class(reduced_t), intent(in) :: self
    !> room of this part
    class(room_t), intent(in) :: room
    !> shape (n_remembered)
    real(rk), intent(inout) :: numbers(:)
  end subroutine nothing_to_save

  !> Goes back to where these numbers were given. Derivatives of later answers take them as given.
  subroutine nothing_to_restore(self, room, numbers, is_valid)
    class(reduced_t), intent(in) :: self
    !> room of this part
    class(room_t), intent(inout) :: room
    !> shape (n_remembered)
    real(rk), intent(in) :: numbers(:)
    !> false: these are no such numbers; then the history begins
    logical, intent(out) :: is_valid

    is_valid = .true.
  end subroutine nothing_to_restore

  !> Improves contact forces that another part found, if this part can see that some are wrong. This default does nothing.
  subroutine nothing_to_correct(self, theta, room, multipliers)
    class(reduced_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> room of this part
    class(room_t), intent(inout) :: room
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: multipliers(:)
  end subroutine nothing_to_correct

  !> Sets the bounds of an answer, which limit the error of given contact forces. This part or another one found the forces; not
  !> every kind bounds those of another part. The bounds do not change where this part cannot give them, as in this default.
  subroutine no_certificate(self, multipliers, is_own, room, answer)
    class(reduced_t), intent(in) :: self
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> whether this part has just solved for these forces
    logical, intent(in) :: is_own
    !> room of this part
    class(room_t), intent(inout) :: room
    !> in: theta, and unknowns if is_own; out: bound and relative_bound; in some kinds the bounds of the displacement, too
    type(answer_t), intent(inout) :: answer
  end subroutine no_certificate

  !> Computes the derivatives of an answer with respect to each parameter. Errors: message is allocated when the answer has no
  !> derivative, as in this default.
  subroutine no_derivative(self, answer, gradient, message, room)
    class(reduced_t), intent(in) :: self
    !> answer of this part
    type(answer_t), intent(in) :: answer
    !> in: direction, is_one_sided, n_given and theta, the derivatives of the terms; out: multipliers, n_grazing and the data for
    !> displacement_changes; is_one_sided becomes true for more parameters where a contact that grazes makes it so
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    !> room of this part, in which `solve` found the answer last; a part that remembers has no derivatives without it
    class(room_t), intent(inout), optional :: room

    message = 'an answer of the kind ' // self%kind() // ' has no derivatives, unless the model keeps the full-order operator ' // &
      '(reduction.max_full_order_size) and this has an answer at the point; the kinds condensed, interpolated and tied have them'
  end subroutine no_derivative

  !> Computes the derivatives of the displacement of the given dofs with respect to one parameter; NaN for dofs without one, as for
  !> all in this default.
  subroutine no_changes(self, answer, gradient, i_parameter, dofs, changes)
    class(reduced_t), intent(in) :: self
    !> the answer that differentiate was called with
    type(answer_t), intent(in) :: answer
    !> result of differentiate
    type(gradient_t), intent(in) :: gradient
    !> number of the parameter, 1-based
    integer, intent(in) :: i_parameter
    !> dofs, 1-based
    integer, intent(in) :: dofs(:)
    !> [length per unit of the parameter] shape (size(dofs))
    real(rk), intent(out) :: changes(:)

    changes = ieee_value(1.0_rk, ieee_quiet_nan)
  end subroutine no_changes

  !> Returns for each parameter a bound of the error of the displacement's derivative in the norm of the stiffness, relative to the
  !> size of this derivative, which counts as at least a thousandth of the largest displacement in training over the range of the
  !> parameter; no_bound where it is not known, as in this default.
  function no_change_errors(self, answer, gradient) result(errors)
    class(reduced_t), intent(in) :: self
    !> the answer that differentiate was called with
    type(answer_t), intent(in) :: answer
    !> result of differentiate
    type(gradient_t), intent(in) :: gradient
    !> [-] shape (n_parameters)
    real(rk), allocatable :: errors(:)

    allocate (errors(size(gradient%theta, 2)), source=no_bound)
  end function no_change_errors
end module sig_reduced
