! SPDX-License-Identifier: BSD-3-Clause
!> A contact problem whose materials flow (plasticity, creep), as a kind of reduced model. The elastic structure and the contact are
!> exact, and only the material is reduced: with the responses G and H of a condensed model,
!>
!>     u = G theta - H z + U a,   a = sum_g w_g E_U,g' s_g,   s = C eps - sigma = C eps_in.
!>
!> U are inelastic modes, orthonormal in the norm of the stiffness; a are their amplitudes. The sum is over the chosen points, whose
!> weights make it equal to the integral over all bodies that flow. For given a the contact problem has openings that are smaller
!> by B U a, so that each step of Newton's method on a solves it exactly.
!>
!> Behind a step the laws are evaluated at more points, the check points, with the strains of the answer. The openings that these
!> inelastic strains cause, H' int B' s, give the forces of the answer; their difference from those before, over their size, is an
!> estimate of the error of the forces before. It is no bound. Only where a room has_points, for fields, or all points are check
!> points, are the laws evaluated at all points, too: that takes several times as long as all the rest.
!>
!> Both sets of contact forces have a history of their own, because contacts with friction remember.
module sig_inelastic_model
  use sig_answer, only: answer_condensed, answer_t
  use sig_body_compliance, only: body_compliance_t
  use sig_condensed_model, only: condensed_model_t
  use sig_description_line, only: line
  use sig_elasticity, only: n_stresses
  use sig_errors, only: error_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_flow_points, only: flow_law_t, flow_points_t, flow_room_t, most_states
  use sig_flow_properties, only: compiled_properties_t, flow_properties_t
  use sig_gradient, only: gradient_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t, multiply
  use sig_material_law, only: creep_strain_at, creep_strains, plastic_strain_at, plastic_strains
  use sig_material_laws, only: make_law
  use sig_missing_parts, only: fill_missing
  use sig_property_checks, only: rule_of
  use sig_reasons, only: put_reason, reason_bad_property, reason_bad_term, reason_no_material_answer
  use sig_reduced, only: model_sizes_t, neighbors_t, reduced_t, room_t
  use sig_shape_checks, only: is_matrix
  use sig_term_check, only: are_sound_terms
  use sig_term_file, only: read_terms, write_terms
  use sig_term_set, only: start_terms, term_set_t
  use sig_term_values, only: term_values_t
  use sig_text, only: counted, string_t, to_text
  implicit none(type, external)
  private
  public :: inelastic_model_t

  type, extends(reduced_t) :: inelastic_model_t
    !> the elastic structure and its contacts. Elastic constants of bodies in which nothing flows may depend on the parameters: all
    !> that follows is the same for any of them
    type(condensed_model_t) :: contact
    !> names of the materials that flow in the deck, and of their laws (sig_material_laws), strains of their hardening curves one
    !> after the other (those of material m are curve_starts(m) + 1 to curve_starts(m + 1)), and [force/length**2] elastic stress
    !> per strain, shape (n_stresses, n_stresses * n_materials)
    type(string_t), allocatable :: material_names(:)
    type(string_t), allocatable :: law_names(:)
    real(rk), allocatable :: curve_strains(:)
    integer, allocatable :: curve_starts(:)
    real(rk), allocatable :: hooke(:, :)
    type(flow_properties_t) :: properties
    !> factors of the imposed strains
    type(term_set_t) :: strain_terms
    !> few points that stand for all, more of them, and all points
    type(flow_points_t) :: chosen
    type(flow_points_t) :: check
    type(flow_points_t) :: all
    !> whether all points are check points; then `check` is not read, so that large arrays are not stored twice
    logical :: checks_all = .false.
    !> [length/sqrt(force*length)] minus B U, shape (n_multipliers, n_modes), and U, shape (n_dofs, n_modes)
    real(rk), allocatable :: mode_openings(:, :)
    real(rk), allocatable :: modes(:, :)
    !> [sqrt(force*length)] largest size of a in training
    real(rk) :: largest_amplitude = 0
    !> from `prepare`
    type(flow_law_t), allocatable, private :: laws(:)
  contains
    procedure :: kind => kind_of
    procedure :: complete
    procedure :: mismatch
    procedure :: prepare
    procedure :: make_laws
    procedure :: create_room
    procedure :: remembers
    procedure :: begin_step
    procedure :: forget
    procedure :: n_remembered
    procedure :: n_flow_points
    procedure :: put_refusal
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
    procedure :: differentiate
    procedure, private :: has_law_besides
  end type inelastic_model_t

  !> A contact problem with a history of its own.
  type :: chain_t
    type(answer_t) :: answer
    !> what contacts remember at the start of the step, and behind the last solution
    real(rk), allocatable :: memory(:)
    real(rk), allocatable :: next_memory(:)
    !> [length] what the inelastic strains open, shape (n_rows)
    real(rk), allocatable :: openings(:)
  end type chain_t

  !> How unknowns, openings and strains of the chosen points follow the amplitudes and, where W is fixed and the terms are few, the
  !> terms, as long as no contact closes or opens: they are linear, without a constant part. What changes per amplitude and term
  !> stays the same from one time to the next where W is fixed.
  type :: course_t
    !> whether the terms are followed, too
    logical :: has_terms = .false.
    !> whether the changes are known, and those of which closed contacts they are, shape (n_rows)
    logical :: is_known = .false.
    logical, allocatable :: is_closed(:)
    !> what opens the contacts by itself: per amplitude minus B U, per term D - B G; shape (n_rows, n_directions)
    real(rk), allocatable :: own_openings(:, :)
    !> per amplitude or term: unknowns and openings, shape (n_rows, n_directions), and strains, shape (n_strains * n_points,
    !> n_directions)
    real(rk), allocatable :: unknown_changes(:, :)
    real(rk), allocatable :: opening_changes(:, :)
    real(rk), allocatable :: strain_changes(:, :)
    !> whether there is a solution to start from, and the amplitudes, openings, unknowns and strains of it. Where the terms are
    !> followed, the start is where all is zero
    logical :: has_start = .false.
    real(rk), allocatable :: amplitudes(:)
    real(rk), allocatable :: openings(:)
    real(rk), allocatable :: unknowns(:)
    real(rk), allocatable :: strains(:)
    !> openings and unknowns where `follow` went last, and whether the contact has been solved there instead
    real(rk), allocatable :: openings_there(:)
    real(rk), allocatable :: unknowns_there(:)
    logical :: is_solved = .false.
  end type course_t

  type, extends(room_t) :: inelastic_room_t
    !> of both contact problems, one after the other, which have most factors in common
    class(room_t), allocatable :: contact
    !> contact for given amplitudes, and for the inelastic strains of the check points
    type(chain_t) :: reduced
    type(chain_t) :: corrected
    type(course_t) :: course
    type(flow_room_t) :: chosen
    type(flow_room_t) :: check
    type(flow_room_t) :: all
    type(compiled_properties_t) :: properties
    type(term_values_t) :: strain_terms
    !> values of strain_terms
    real(rk), allocatable :: strain_theta(:)
    !> [sqrt(force*length)] a, at the last time and now
    real(rk), allocatable :: old_amplitudes(:)
    real(rk), allocatable :: amplitudes(:)
    !> numbers of the state, and [time] the length of the step
    real(rk), allocatable :: state(:)
    real(rk) :: dt = 0
  contains
    final :: free_room
  end type inelastic_room_t

  !> Newton's method ends where the residual is at most this share of the amplitudes
  real(rk), parameter :: tolerance = 1.0e-10_rk
  integer, parameter :: most_iterations = 40
  !> a step is tried in most_trials lengths at most, each at least this share of the one before
  integer, parameter :: most_trials = 15
  real(rk), parameter :: shortest = 0.1_rk
  !> more terms than these are not followed (course_t)
  integer, parameter :: most_terms = 32

contains

  pure function kind_of(self) result(name)
    class(inelastic_model_t), intent(in) :: self
    character(:), allocatable :: name

    name = 'inelastic'
  end function kind_of

  !> Allocates each array that is not allocated, with size 0 or without values.
  pure subroutine complete(self, sizes)
    class(inelastic_model_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes
    integer :: n_modes

    call self%contact%complete(sizes)
    call fill_missing(self%mode_openings, sizes%n_multipliers)
    call fill_missing(self%modes, sizes%n_dofs)
    call fill_missing(self%material_names)
    call fill_missing(self%law_names)
    call fill_missing(self%curve_strains)
    call fill_missing(self%curve_starts)
    call fill_missing(self%hooke, n_stresses)
    call self%properties%complete()
    if (self%strain_terms%n_terms() == 0) call start_terms(self%properties%names, [string_t ::], .false., self%strain_terms)
    n_modes = size(self%modes, 2)
    call self%chosen%complete(sizes%n_terms, sizes%n_multipliers, n_modes)
    call self%check%complete(sizes%n_terms, sizes%n_multipliers, n_modes)
    call self%all%complete(sizes%n_terms, sizes%n_multipliers, n_modes)
  end subroutine complete

  !> Returns the name of an array whose shape or values do not fit the model; empty when all fit. Requires: complete.
  pure function mismatch(self, sizes) result(name)
    class(inelastic_model_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = self%contact%mismatch(sizes)
    associate (n_modes => size(self%modes, 2), n => size(self%law_names))
      if (.not. is_matrix(self%modes, sizes%n_dofs, n_modes)) name = 'modes'
      if (.not. is_matrix(self%mode_openings, sizes%n_multipliers, n_modes)) name = 'mode_openings'
      if (size(self%material_names) /= n) name = 'materials'
      if (.not. is_matrix(self%hooke, n_stresses, n_stresses * n)) name = 'hooke'
      if (.not. (self%largest_amplitude >= 0 .and. self%largest_amplitude <= huge(1.0_rk))) name = 'largest_amplitude'
      if (.not. are_starts(self%curve_starts, n, size(self%curve_strains))) name = 'curve_starts'
      if (name == '') name = self%properties%mismatch(n)
      if (name == '' .and. .not. are_sound_terms(self%strain_terms, 3)) name = 'strain_terms'
      if (name == '') name = self%chosen%mismatch(n, size(self%properties%temperatures), &
        self%strain_terms%n_terms(), sizes%n_terms, sizes%n_multipliers, n_modes)
      if (name == '' .and. .not. self%checks_all) name = self%check%mismatch(n, size(self%properties%temperatures), &
        self%strain_terms%n_terms(), sizes%n_terms, sizes%n_multipliers, n_modes)
      if (name == '') name = self%all%mismatch(n, size(self%properties%temperatures), &
        self%strain_terms%n_terms(), sizes%n_terms, sizes%n_multipliers, n_modes)
    end associate
  end function mismatch

  !> Whether a list numbers what belongs to each of n materials, from 0 to the number of all.
  pure logical function are_starts(starts, n, n_all)
    integer, intent(in) :: starts(:)
    integer, intent(in) :: n
    integer, intent(in) :: n_all

    are_starts = size(starts) == n + 1
    if (are_starts) are_starts = starts(1) == 0 .and. starts(n + 1) == n_all .and. all(starts(2:) >= starts(:n))
  end function are_starts

  !> Prepares contact and laws. Errors: message is allocated as by make_laws, or if an expression is not valid.
  subroutine prepare(self, message)
    class(inelastic_model_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    type(compiled_properties_t) :: compiled
    type(term_values_t) :: values

    call self%contact%prepare(message)
    if (allocated(message)) return
    call self%make_laws(self%laws, message)
    if (allocated(message)) return
    call self%properties%compile(compiled, message)
    if (.not. allocated(message)) call values%create(self%strain_terms, message)
    call values%destroy()
  end subroutine prepare

  !> Makes the laws of all materials. Errors: message is allocated if there is no such law, or properties are missing.
  subroutine make_laws(self, laws, message)
    class(inelastic_model_t), intent(in) :: self
    type(flow_law_t), allocatable, intent(out) :: laws(:)
    character(:), allocatable, intent(out) :: message
    integer :: i

    allocate (laws(size(self%law_names)))
    do i = 1, size(laws)
      associate (law => laws(i))
        call make_law(self%law_names(i)%text, self%curve_strains(self%curve_starts(i) + 1:self%curve_starts(i + 1)), law%law)
        if (.not. allocated(law%law)) then
          message = 'it has a material law ''' // self%law_names(i)%text // ''', which this version does not know'
          return
        end if
        if (law%law%n_properties() /= self%properties%starts(i + 1) - self%properties%starts(i)) then
          message = 'the material law ''' // self%law_names(i)%text // ''' has other properties'
          return
        end if
        law%hooke = self%hooke(:, n_stresses * (i - 1) + 1:n_stresses * i)
      end associate
    end do
  end subroutine make_laws

  !> Makes the work arrays for one thread, at the beginning of a history.
  subroutine create_room(self, room)
    class(inelastic_model_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(inelastic_room_t), allocatable :: own
    character(:), allocatable :: message

    allocate (own)
    call self%contact%create_room(own%contact)
    call self%contact%keep_factors(own%contact)
    call create_chain(self, own%reduced)
    call create_chain(self, own%corrected)
    call self%chosen%create_room(self%laws, own%chosen)
    call self%check%create_room(self%laws, own%check)
    call self%all%create_room(self%laws, own%all)
    call create_course(self, size(self%chosen%of_terms, 2), own%contact, own%course)
    call self%properties%compile(own%properties, message)
    call own%strain_terms%create(self%strain_terms, message)
    allocate (own%strain_theta(self%strain_terms%n_terms()), source=0.0_rk)
    allocate (own%old_amplitudes(self%n_modes()), own%amplitudes(self%n_modes()), own%state(size(self%properties%names)), &
      source=0.0_rk)
    call self%forget(own)
    call move_alloc(own, room)
  end subroutine create_room

  !> Frees the expressions of a room.
  subroutine free_room(room)
    type(inelastic_room_t), intent(inout) :: room

    call room%strain_terms%destroy()
  end subroutine free_room

  subroutine create_chain(self, chain)
    class(inelastic_model_t), intent(in) :: self
    type(chain_t), intent(inout) :: chain

    associate (n => self%contact%n_remembered())
      allocate (chain%memory(n), chain%next_memory(n), chain%openings(self%n_rows()), source=0.0_rk)
    end associate
  end subroutine create_chain

  subroutine create_course(self, n_terms, contact, course)
    class(inelastic_model_t), intent(in) :: self
    integer, intent(in) :: n_terms
    class(room_t), intent(in) :: contact
    type(course_t), intent(inout) :: course
    integer :: n_directions

    course%has_terms = self%contact%compliance%is_fixed() .and. n_terms <= most_terms
    associate (n => self%n_rows(), n_modes => self%n_modes(), n_strains => size(self%chosen%of_modes, 1))
      n_directions = n_modes + merge(n_terms, 0, course%has_terms)
      allocate (course%own_openings(n, n_directions))
      course%own_openings(:, :n_modes) = self%mode_openings
      if (course%has_terms) course%own_openings(:, n_modes + 1:) = self%contact%openings_of_terms(contact, n_terms)
      allocate (course%is_closed(n), source=.false.)
      allocate (course%unknown_changes(n, n_directions), course%opening_changes(n, n_directions), &
        course%strain_changes(n_strains, n_directions), course%amplitudes(n_modes), course%openings(n), course%unknowns(n), &
        course%strains(n_strains), course%openings_there(n), course%unknowns_there(n), source=0.0_rk)
    end associate
  end subroutine create_course

  !> Returns true: materials that flow carry their state from one time to the next.
  pure logical function remembers(self)
    class(inelastic_model_t), intent(in) :: self

    remembers = .true.
  end function remembers

  !> Begins a history: the virgin state.
  subroutine forget(self, room)
    class(inelastic_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room

    select type (room)
    type is (inelastic_room_t)
      call self%contact%forget(room%contact)
      call self%contact%start_from_set(room%contact, [logical ::])
      call self%contact%save_memory(room%contact, room%reduced%next_memory)
      room%corrected%next_memory = room%reduced%next_memory
      room%course%is_known = .false.
      room%chosen%old_states = 0
      room%check%old_states = 0
      room%all%old_states = 0
      room%old_amplitudes = 0
    end select
  end subroutine forget

  !> Takes the numbers of the next state and the length of its step.
  subroutine begin_step(self, room, state, dt)
    class(inelastic_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room
    real(rk), intent(in) :: state(:)
    real(rk), intent(in) :: dt

    select type (room)
    type is (inelastic_room_t)
      room%state = state
      room%dt = dt
    end select
  end subroutine begin_step

  pure integer function n_remembered(self) result(n)
    class(inelastic_model_t), intent(in) :: self

    n = 2 * self%contact%n_remembered() + self%n_modes() + most_states(self%laws) * (self%chosen%n_points() + &
      self%check%n_points() + self%all%n_points())
  end function n_remembered

  pure integer function n_flow_points(self) result(n)
    class(inelastic_model_t), intent(in) :: self

    n = self%all%n_points()
  end function n_flow_points

  subroutine save_memory(self, room, numbers)
    class(inelastic_model_t), intent(in) :: self
    class(room_t), intent(in) :: room
    real(rk), intent(inout) :: numbers(:)
    integer :: n

    select type (room)
    type is (inelastic_room_t)
      n = self%contact%n_remembered()
      numbers(:n) = room%reduced%next_memory
      numbers(n + 1:2 * n) = room%corrected%next_memory
      numbers(2 * n + 1:) = [room%old_amplitudes, room%chosen%old_states, room%check%old_states, room%all%old_states]
    end select
  end subroutine save_memory

  subroutine restore_memory(self, room, numbers, is_valid)
    class(inelastic_model_t), intent(in) :: self
    class(room_t), intent(inout) :: room
    real(rk), intent(in) :: numbers(:)
    logical, intent(out) :: is_valid
    logical :: is_other
    integer :: first, n

    is_valid = all(abs(numbers) <= huge(numbers))
    call self%forget(room)
    if (.not. is_valid) return
    select type (room)
    type is (inelastic_room_t)
      n = self%contact%n_remembered()
      room%reduced%next_memory = numbers(:n)
      room%corrected%next_memory = numbers(n + 1:2 * n)
      call self%contact%restore_memory(room%contact, room%reduced%next_memory, is_valid)
      call self%contact%restore_memory(room%contact, room%corrected%next_memory, is_other)
      is_valid = is_valid .and. is_other
      first = 2 * n + self%n_modes()
      room%old_amplitudes = numbers(2 * n + 1:first)
      call take_states(room%chosen)
      call take_states(room%check)
      call take_states(room%all)
    end select

  contains

    !> Takes the states of points from the numbers behind `first`.
    subroutine take_states(points)
      type(flow_room_t), intent(inout) :: points

      n = size(points%old_states)
      points%old_states = reshape(numbers(first + 1:first + n), shape(points%old_states))
      first = first + n
    end subroutine take_states
  end subroutine restore_memory

  !> Solves the next step of the history in the room. Requires: begin_step. Arguments: solve_at in sig_reduced; no judge is asked.
  subroutine solve(self, theta, near, room, answer, judge)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    class(reduced_t), intent(in), optional :: judge
    integer :: i_source, reason
    logical :: is_valid

    select type (room)
    type is (inelastic_room_t)
      call room%strain_terms%evaluate(room%state, room%strain_theta, is_valid, i_source)
      answer%reason = reason_bad_term
      if (.not. is_valid) return
      room%course%has_start = room%course%has_terms
      room%course%is_known = room%course%is_known .and. self%contact%compliance%is_fixed()
      call start_chain(self, theta, room%reduced)
      call start_chain(self, theta, room%corrected)
      call room%properties%evaluate(room%state, self%chosen%materials, self%chosen%temperatures, room%chosen%properties)
      if (.not. self%checks_all) &
        call room%properties%evaluate(room%state, self%check%materials, self%check%temperatures, room%check%properties)
      if (room%has_points .or. self%checks_all) then
        call room%properties%evaluate(room%state, self%all%materials, self%all%temperatures, room%all%properties)
        answer%flaw = self%all%find_flaw(self%laws, room%all)
      else
        answer%flaw = self%check%find_flaw(self%laws, room%check)
      end if
      call self%chosen%impose(room%strain_theta, room%chosen)
      answer%reason = reason_bad_property
      if (answer%flaw(1) > 0) return
      call find_amplitudes(self, theta, room, answer%n_iterations, reason)
      if (reason > 0) call correct(self, theta, room, reason)
      answer%reason = reason
      if (reason <= 0) return
      call take_answer(self, room, answer)
      room%old_amplitudes = room%amplitudes
      room%chosen%old_states = room%chosen%states
      room%check%old_states = room%check%states
      if (room%has_points .or. self%checks_all) room%all%old_states = room%all%states
    end select
  end subroutine solve

  !> Writes why the answer is none: which property of which material is out of its range, if that is why. Arguments:
  !> put_usual_refusal in sig_reduced.
  pure subroutine put_refusal(self, answer, text)
    class(inelastic_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    character(*), intent(out) :: text

    call put_reason(answer%reason, text)
    if (answer%reason /= reason_bad_property .or. any(answer%flaw < 1)) return
    associate (law => self%laws(answer%flaw(1))%law, material => self%material_names(answer%flaw(1)))
      associate (property => law%property_names(answer%flaw(2)))
        text = trim(property) // ' of the material ''' // material%text // &
          ''' is not finite or out of its range at an integration point: ' // rule_of(property)
      end associate
    end associate
  end subroutine put_refusal

  !> Keeps what the contacts remember, and prepares the answer of a chain.
  subroutine start_chain(self, theta, chain)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(chain_t), intent(inout) :: chain

    chain%memory = chain%next_memory
    associate (n => self%n_rows())
      call chain%answer%start(1, size(theta), self%contact%n_modes(), n, n)
    end associate
    chain%answer%theta = theta
  end subroutine start_chain

  !> Solves the contact problem of a chain from the start of the step, with its openings.
  subroutine solve_contact(self, room, chain)
    class(inelastic_model_t), intent(in) :: self
    !> of the contact
    class(room_t), intent(inout) :: room
    type(chain_t), intent(inout) :: chain
    logical :: is_valid

    call self%contact%restore_memory(room, chain%memory, is_valid)
    call self%contact%open_contacts(room, chain%openings)
    chain%answer%n_iterations = 0
    call self%contact%solve(chain%answer%theta, neighbors_t(), room, chain%answer)
    call self%contact%save_memory(room, chain%next_memory)
    ! the next problem has nearly the same openings
    if (chain%answer%reason > 0) call self%contact%start_from_set(room, chain%answer%unknowns > 0)
  end subroutine solve_contact

  !> Finds the amplitudes by Newton's method on R = a - sum_g w_g E_U,g' s_g = 0. reason <= 0 says why there are none.
  subroutine find_amplitudes(self, theta, room, n_iterations, reason)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(inelastic_room_t), intent(inout) :: room
    integer, intent(out) :: n_iterations
    integer, intent(out) :: reason
    real(rk), dimension(self%n_modes()) :: residual, step
    logical :: is_found

    room%amplitudes = room%old_amplitudes
    n_iterations = 0
    call measure(self, theta, room, residual, reason)
    do while (reason > 0)
      if (norm2(residual) <= tolerance * max(norm2(room%amplitudes), self%largest_amplitude)) then
        call settle_contact(self, theta, room)
        return
      end if
      reason = reason_no_material_answer
      if (n_iterations == most_iterations) return
      n_iterations = n_iterations + 1
      call find_step(self, room, residual, step, is_found)
      if (is_found) call take_step(self, theta, room, step, residual, reason)
    end do
  end subroutine find_amplitudes

  !> Goes along a step of Newton's method, as far as R * step does not rise above half of its size at the start. Without contact R
  !> is the gradient of an energy, and this is its slope, which rises along the step. |R| may rise at first where the solution is
  !> far.
  subroutine take_step(self, theta, room, step, residual, reason)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(inelastic_room_t), intent(inout) :: room
    real(rk), intent(in) :: step(:)
    !> [sqrt(force*length)] R, at the start and at the end; shape (n_modes)
    real(rk), contiguous, intent(inout) :: residual(:)
    !> <= 0: the step leads uphill, or no part of it is short enough
    integer, intent(out) :: reason
    real(rk) :: length, slope, slope_there, start(size(step))
    integer :: i

    start = room%amplitudes
    slope = dot_product(residual, step)
    length = 1
    do i = 1, merge(most_trials, 0, slope < 0)
      room%amplitudes = start + length * step
      call measure(self, theta, room, residual, reason)
      slope_there = -slope
      if (reason > 0) slope_there = dot_product(residual, step)
      if (slope_there <= -slope / 2) return
      ! where a straight line between the two slopes is zero
      length = length * max(shortest, slope / (slope - slope_there))
    end do
    reason = reason_no_material_answer
  end subroutine take_step

  !> Computes contact, states and the residual for the amplitudes in the room.
  subroutine measure(self, theta, room, residual, reason)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(inelastic_room_t), intent(inout) :: room
    !> [sqrt(force*length)] shape (n_modes)
    real(rk), contiguous, intent(inout) :: residual(:)
    integer, intent(out) :: reason
    logical :: is_valid

    reason = 1
    call follow(room%course, room%amplitudes, theta, room%chosen%strains, is_valid)
    if (.not. is_valid) call open_course(self, theta, room, reason)
    if (reason <= 0) return
    call self%chosen%apply_laws(self%laws, room%dt, room%chosen, is_valid)
    call self%chosen%work_on_modes(room%chosen, residual)
    residual = room%amplitudes - residual
    if (.not. is_valid) reason = reason_no_material_answer
  end subroutine measure

  !> Solves the contact for the amplitudes in the room, finds strains, and starts a course from there.
  subroutine open_course(self, theta, room, reason)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(inelastic_room_t), intent(inout) :: room
    integer, intent(out) :: reason

    call multiply(1.0_rk, self%mode_openings, room%amplitudes, 0.0_rk, room%reduced%openings)
    call solve_contact(self, room%contact, room%reduced)
    associate (course => room%course, answer => room%reduced%answer, strains => room%chosen%strains)
      reason = answer%reason
      course%has_start = .false.
      course%is_solved = .true.
      if (reason <= 0) return
      call self%chosen%find_strains(theta, answer%unknowns, room%amplitudes, strains)
      if (.not. self%contact%laws%is_plain()) return
      course%has_start = .true.
      if (any((answer%unknowns > 0) .neqv. course%is_closed)) course%is_known = .false.
      course%is_closed = answer%unknowns > 0
      if (course%has_terms) return
      course%amplitudes = room%amplitudes
      course%unknowns = answer%unknowns
      call self%contact%take_openings(room%contact, course%openings)
      course%strains = strains
    end associate
  end subroutine open_course

  !> Finds the strains for amplitudes along a course. is_valid: there is a course, and no contact closes or opens.
  subroutine follow(course, amplitudes, theta, strains, is_valid)
    type(course_t), intent(inout) :: course
    real(rk), intent(in) :: amplitudes(:)
    real(rk), intent(in) :: theta(:)
    real(rk), contiguous, intent(inout) :: strains(:)
    logical, intent(out) :: is_valid
    real(rk) :: step(size(course%unknown_changes, 2))

    is_valid = course%has_start .and. course%is_known
    if (.not. is_valid) return
    step(:size(amplitudes)) = amplitudes - course%amplitudes
    if (course%has_terms) step(size(amplitudes) + 1:) = theta
    course%unknowns_there = course%unknowns
    call multiply(1.0_rk, course%unknown_changes, step, 1.0_rk, course%unknowns_there)
    course%openings_there = course%openings
    call multiply(1.0_rk, course%opening_changes, step, 1.0_rk, course%openings_there)
    is_valid = all(merge(course%unknowns_there > 0, course%openings_there >= 0, course%is_closed))
    if (.not. is_valid) return
    course%is_solved = .false.
    strains = course%strains
    call multiply(1.0_rk, course%strain_changes, step, 1.0_rk, strains)
  end subroutine follow

  !> Takes the contact forces that were found along a course. All signs are right there, so that they are those of the amplitudes.
  subroutine settle_contact(self, theta, room)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(inelastic_room_t), intent(inout) :: room

    associate (course => room%course, chain => room%reduced)
      if (course%is_solved) return
      call multiply(1.0_rk, self%mode_openings, room%amplitudes, 0.0_rk, chain%openings)
      call self%contact%open_contacts(room%contact, chain%openings)
      call self%contact%take_unknowns(room%contact, theta, course%unknowns_there, course%openings_there, chain%answer)
    end associate
  end subroutine settle_contact

  !> Computes the step of Newton's method. Where contact forces have no derivative they count as fixed.
  subroutine find_step(self, room, residual, step, is_found)
    class(inelastic_model_t), intent(in) :: self
    type(inelastic_room_t), intent(inout) :: room
    real(rk), intent(in) :: residual(:)
    real(rk), intent(out) :: step(:)
    logical, intent(out) :: is_found
    real(rk) :: matrix(self%n_modes(), self%n_modes())
    type(lu_t) :: lu
    integer :: i

    if (.not. (room%course%has_start .and. room%course%is_known)) call find_course(self, room)
    call self%chosen%change_of_work(room%chosen, room%course%strain_changes(:, :self%n_modes()), matrix)
    matrix = -matrix
    do i = 1, size(step)
      matrix(i, i) = matrix(i, i) + 1
    end do
    call lu%factor(matrix)
    is_found = .not. lu%is_singular
    step = 0
    if (is_found) step = -lu%solve(residual)
  end subroutine find_step

  !> Finds what changes with the amplitudes, and with the terms where they are followed.
  subroutine find_course(self, room)
    class(inelastic_model_t), intent(in) :: self
    type(inelastic_room_t), intent(inout) :: room

    associate (course => room%course, n_modes => self%n_modes())
      call self%contact%unknown_changes(room%contact, room%reduced%answer, course%own_openings, course%unknown_changes, &
        course%is_known)
      course%strain_changes(:, :n_modes) = self%chosen%of_modes
      if (course%has_terms) course%strain_changes(:, n_modes + 1:) = self%chosen%of_terms
      call self%chosen%add_contact_strains(course%unknown_changes, course%strain_changes)
      course%is_known = course%is_known .and. course%has_start
      if (.not. course%is_known) return
      course%opening_changes = course%own_openings
      call self%contact%opening_changes(room%contact, course%is_closed, course%unknown_changes, course%opening_changes)
    end associate
  end subroutine find_course

  !> Evaluates the laws at more points, and solves for the contact forces under the inelastic strains of these; without check points
  !> the forces stay as they are. Where the states of all points are wanted, it finds these, too.
  subroutine correct(self, theta, room, reason)
    class(inelastic_model_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(inelastic_room_t), intent(inout) :: room
    integer, intent(out) :: reason
    logical :: is_solved

    if (self%checks_all) then
      call correct_by(self%all, room%all)
    else if (self%check%n_points() == 0) then
      room%corrected = room%reduced
      is_solved = .true.
    else
      call correct_by(self%check, room%check)
    end if
    reason = room%corrected%answer%reason
    if (is_solved .and. room%has_points .and. .not. self%checks_all) call update_points(self%all, room%all)
    if (.not. is_solved) reason = reason_no_material_answer

  contains

    subroutine correct_by(points, of_points)
      type(flow_points_t), intent(in) :: points
      type(flow_room_t), intent(inout) :: of_points

      call update_points(points, of_points)
      call points%work_on_contact(of_points, room%corrected%openings)
      call solve_contact(self, room%contact, room%corrected)
    end subroutine correct_by

    subroutine update_points(points, of_points)
      type(flow_points_t), intent(in) :: points
      type(flow_room_t), intent(inout) :: of_points

      call points%update(self%laws, theta, room%strain_theta, room%reduced%answer%unknowns, room%amplitudes, room%dt, of_points, &
        is_solved)
    end subroutine update_points
  end subroutine correct

  !> Copies the answer from the room: forces of the corrected contact, and amplitudes by the check points.
  subroutine take_answer(self, room, answer)
    class(inelastic_model_t), intent(in) :: self
    type(inelastic_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    associate (found => room%corrected%answer)
      answer%method = answer_condensed
      answer%residual = found%residual
      answer%n_solutions = found%n_solutions
      answer%n_free_motions = found%n_free_motions
      answer%multipliers = found%multipliers
      answer%raw_multipliers = room%reduced%answer%multipliers
      answer%unknowns = found%unknowns
      if (allocated(found%slip)) then
        answer%slip = found%slip
        answer%slips = found%slips
      end if
      call answer%take_all_forces()
      answer%is_active = found%is_active
      answer%coordinates = room%amplitudes
      if (self%checks_all) then
        call self%all%work_on_modes(room%all, answer%coordinates)
      else if (self%check%n_points() > 0) then
        call self%check%work_on_modes(room%check, answer%coordinates)
      end if
      if (allocated(answer%plastic)) deallocate (answer%plastic)
      if (allocated(answer%creep)) deallocate (answer%creep)
      if (room%has_points) then
        if (self%has_law_besides('norton_creep')) answer%plastic = room%all%states([plastic_strains, plastic_strain_at], :)
        if (self%has_law_besides('plasticity')) answer%creep = room%all%states([creep_strains, creep_strain_at], :)
      end if
      answer%error_estimate = norm2(found%multipliers - room%reduced%answer%multipliers)
      if (answer%error_estimate > 0) answer%error_estimate = answer%error_estimate / norm2(found%multipliers)
    end associate
  end subroutine take_answer

  !> Whether some material has another law than this one.
  pure logical function has_law_besides(self, name)
    class(inelastic_model_t), intent(in) :: self
    character(*), intent(in) :: name
    integer :: i

    has_law_besides = .false.
    do i = 1, size(self%law_names)
      has_law_besides = has_law_besides .or. self%law_names(i)%text /= name
    end do
  end function has_law_besides

  !> Copies the forces of all contacts from the answer, which has them already; `room` is not used.
  subroutine fill_multipliers(self, answer, room, multipliers)
    class(inelastic_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    class(room_t), intent(inout) :: room
    real(rk), intent(out) :: multipliers(:)

    multipliers = answer%multipliers
  end subroutine fill_multipliers

  !> Computes the displacement [length] of all dofs, shape (n_dofs); it is NaN for dofs of which there is none.
  subroutine fill_displacement(self, answer, displacement)
    class(inelastic_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    call self%contact%fill_displacement(answer, displacement)
    call multiply(1.0_rk, self%modes, answer%coordinates, 1.0_rk, displacement)
  end subroutine fill_displacement

  !> Returns the displacement [length] of one dof, 1-based; NaN if there is none of this dof.
  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(inelastic_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof
    integer :: i

    displacement = self%contact%displacement_of_dof(answer, dof)
    do i = 1, size(answer%coordinates)
      displacement = displacement + self%modes(dof, i) * answer%coordinates(i)
    end do
  end function displacement_of_dof

  pure function contact_rows(self) result(numbers)
    class(inelastic_model_t), intent(in) :: self
    integer, allocatable :: numbers(:)

    numbers = self%contact%contact_rows()
  end function contact_rows

  pure integer function n_rows(self)
    class(inelastic_model_t), intent(in) :: self

    n_rows = self%contact%n_rows()
  end function n_rows

  !> Returns the number of inelastic modes.
  pure integer function n_modes(self)
    class(inelastic_model_t), intent(in) :: self

    n_modes = size(self%modes, 2)
  end function n_modes

  !> Writes the part to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(inelastic_model_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call self%contact%write(file, group, length, force)
    call file%write(group // '@compliance', self%contact%kind())
    call file%write(group // '/materials', self%material_names, description='materials that flow')
    call file%write(group // '/laws', self%law_names, description='material laws')
    call file%write(group // '/curve_strains', self%curve_strains, description='equivalent plastic strains of hardening curves')
    call file%write(group // '/curve_starts', self%curve_starts, description='number of strains before those of each material')
    call file%write(group // '/hooke', self%hooke, force // '/' // length // '**2', 'elastic stress per strain of each material')
    call self%properties%write(file, group // '/properties')
    call write_terms(file, group // '/strain_terms', self%strain_terms, length)
    call self%chosen%write(file, group // '/chosen_points', length, force)
    if (.not. self%checks_all) call self%check%write(file, group // '/check_points', length, force)
    call self%all%write(file, group // '/all_points', length, force)
    call file%write(group // '/mode_openings', self%mode_openings, length // '/sqrt(' // force // '*' // length // ')', &
      'opening of each contact by each inelastic mode, a mode per row')
    call file%write(group // '/modes', self%modes, length // '/sqrt(' // force // '*' // length // ')', &
      'displacement of each inelastic mode, a mode per row')
    call file%write(group // '/largest_amplitude', self%largest_amplitude, 'sqrt(' // force // '*' // length // ')', &
      'largest size of the amplitudes in training')
  end subroutine write

  !> Reads the part from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(inelastic_model_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: kind

    ! files of earlier versions do not say it
    kind = 'condensed'
    if (file%has(group // '@compliance')) call file%read(group // '@compliance', kind, error)
    if (allocated(error)) return
    if (kind == 'interpolated') then
      allocate (body_compliance_t :: self%contact%compliance)
    else
      allocate (fixed_compliance_t :: self%contact%compliance)
    end if
    call self%contact%read(file, group, error)
    call file%read(group // '/materials', self%material_names, error)
    call file%read(group // '/laws', self%law_names, error)
    call file%read(group // '/curve_strains', self%curve_strains, error)
    call file%read(group // '/curve_starts', self%curve_starts, error)
    call file%read(group // '/hooke', self%hooke, error)
    call self%properties%read(file, group // '/properties', error)
    if (allocated(error)) return
    call read_terms(file, group // '/strain_terms', '', self%properties%names, self%strain_terms, error)
    call self%chosen%read(file, group // '/chosen_points', error)
    self%checks_all = .not. file%has(group // '/check_points')
    if (self%checks_all) then
      call self%check%complete(0, 0, 0)
    else
      call self%check%read(file, group // '/check_points', error)
    end if
    call self%all%read(file, group // '/all_points', error)
    call file%read(group // '/mode_openings', self%mode_openings, error)
    call file%read(group // '/modes', self%modes, error)
    call file%read(group // '/largest_amplitude', self%largest_amplitude, error)
  end subroutine read

  pure function describe(self) result(text)
    class(inelastic_model_t), intent(in) :: self
    character(:), allocatable :: text

    text = line('  forces', 'on all ' // counted(self%n_rows(), 'contact row') // ', with an estimate of their error')
    if (.not. self%has_displacement()) then
      text = text // line('  displacements', 'none')
    else if (self%has_whole_field(size(self%modes, 1))) then
      text = text // line('  displacements', 'at all nodes')
    else
      text = text // line('  displacements', 'at the nodes that reduction.displacement names')
    end if
    select type (compliance => self%contact%compliance)
    type is (body_compliance_t)
      text = text // compliance%describe_bodies()
    end select
    text = text // line('  inelastic strains', counted(self%n_modes(), 'mode') // ', from ' // to_text(self%chosen%n_points()) // &
      ' of ' // counted(self%all%n_points(), 'integration point'))
  end function describe

  !> Returns true: the forces are those of all contacts, without reconstruction.
  pure logical function is_exact(self)
    class(inelastic_model_t), intent(in) :: self

    is_exact = .true.
  end function is_exact

  pure logical function has_displacement(self)
    class(inelastic_model_t), intent(in) :: self

    has_displacement = self%contact%has_displacement()
  end function has_displacement

  pure logical function has_whole_field(self, n_dofs)
    class(inelastic_model_t), intent(in) :: self
    integer, intent(in) :: n_dofs

    has_whole_field = self%contact%has_whole_field(n_dofs)
  end function has_whole_field

  !> Says that there are no derivatives. Arguments: no_derivative in sig_reduced.
  subroutine differentiate(self, answer, gradient, message, room)
    class(inelastic_model_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    class(room_t), intent(inout), optional :: room

    message = 'there are no derivatives where materials yield or creep'
  end subroutine differentiate

  pure integer function displacement_source(self, dof) result(source)
    class(inelastic_model_t), intent(in) :: self
    integer, intent(in) :: dof

    source = self%contact%displacement_source(dof)
  end function displacement_source
end module sig_inelastic_model
