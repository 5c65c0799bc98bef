! SPDX-License-Identifier: BSD-3-Clause
!> The full-order contact problem condensed to its contacts as a kind of reduced model: exact on all contacts, without a mesh.
!>
!> A query starts from the active set of the nearest training point. Where that has a reference with a principal pivot transform,
!> the transformed problem is solved, in which only the contacts that differ from the reference are unknown.
module sig_reduced_condensed
  use sig_answer, only: answer_condensed, answer_failed_pulled_off, answer_t
  use sig_bits, only: n_words, unpack_bits
  use sig_condensed_data, only: condensed_data_t
  use sig_condensed_displacement, only: condensed_displacement_of_dof, fill_condensed_displacement, source_of_dof
  use sig_contact_error_bound, only: contact_error_bound_t
  use sig_errors, only: error_t
  use sig_hanging_bodies, only: hanging_bodies_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_lcp, only: change_sets, lcp_failed_ray, lcp_solution_t, lcp_workspace_t, solve_lcp
  use sig_linear_algebra, only: multiply
  use sig_pivot_transform, only: transform_columns
  use sig_reduced, only: model_sizes_t, neighbors_t, reduced_t, room_t
  use sig_description_line, only: line
  use sig_text, only: counted, join
  implicit none(type, external)
  private
  public :: reduced_condensed_t

  type, extends(reduced_t) :: reduced_condensed_t
    type(condensed_data_t) :: data
    !> q of each transform, times theta; shape (n_multipliers, n_terms, n_references)
    real(rk), allocatable, private :: transformed_opening(:, :, :)
    !> the sets of the references, shape (n_multipliers, n_references)
    logical, allocatable, private :: reference_sets(:, :)
    !> pairs that are no anchors, and the norm of their compliance
    integer, allocatable, private :: free_rows(:)
    type(contact_error_bound_t), private :: bound
    type(hanging_bodies_t), private :: bodies
  contains
    procedure :: kind => kind_of
    procedure :: complete
    procedure :: mismatch
    procedure :: prepare
    procedure :: create_room
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
    procedure :: displacement_source
    procedure :: has_whole_field
    procedure :: energy
    procedure :: can_certify
    procedure :: certify
  end type reduced_condensed_t

  type, extends(room_t) :: condensed_room_t
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    !> [length] without forces and with them, shape (n_multipliers)
    real(rk), allocatable :: free_opening(:)
    real(rk), allocatable :: opening(:)
    real(rk), allocatable :: transformed(:)
    logical, allocatable :: start(:)
  end type condensed_room_t

  !> [-] a load that works less than this share of its parts on a free motion is in equilibrium
  real(rk), parameter :: rounding = 1.0e-12_rk
  !> [-] a bound is relative to the answer's size, but at least to this share of the largest in training
  real(rk), parameter :: smallest_share = 1.0e-3_rk
  !> [-] a relative bound up to this is called exact
  real(rk), parameter :: exact = 1.0e-12_rk

contains

  pure function kind_of(self) result(name)
    class(reduced_condensed_t), intent(in) :: self
    character(:), allocatable :: name

    name = 'condensed'
  end function kind_of

  pure subroutine complete(self, sizes)
    class(reduced_condensed_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call self%data%complete(sizes)
  end subroutine complete

  pure function mismatch(self, sizes) result(name)
    class(reduced_condensed_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = self%data%mismatch(sizes)
  end function mismatch

  !> Transforms the terms of q, and factors W for bounds. No errors.
  subroutine prepare(self, message)
    class(reduced_condensed_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    integer :: i, n

    n = size(self%data%compliance, 1)
    if (allocated(self%transformed_opening)) deallocate (self%transformed_opening, self%reference_sets)
    associate (points => self%data%reference_points)
      allocate (self%transformed_opening(n, size(self%data%free_opening, 2), size(points)), self%reference_sets(n, size(points)))
      do i = 1, size(points)
        call unpack_bits(self%data%start_sets(:, points(i)), self%reference_sets(:, i))
        self%transformed_opening(:, :, i) = self%data%free_opening
        call transform_columns(self%data%transforms(:, (i - 1) * n + 1:i * n), self%reference_sets(:, i), &
          self%transformed_opening(:, :, i))
      end do
    end associate
    self%free_rows = pack([(i, i=1, n)], [(all(self%data%anchors /= i), i=1, n)])
    call self%bound%create(self%data%compliance(self%free_rows, self%free_rows))
    call self%bodies%create(self%data, self%free_rows)
  end subroutine prepare

  subroutine create_room(self, room)
    class(reduced_condensed_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(condensed_room_t), allocatable :: own
    integer :: n

    n = size(self%data%compliance, 1)
    allocate (own)
    allocate (own%free_opening(n), own%opening(n), own%transformed(n), own%start(n))
    call move_alloc(own, room)
  end subroutine create_room

  !> The complementarity problem of all contacts. With a symmetric W, which is positive semidefinite, it has a solution.
  subroutine solve(self, theta, near, judge, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(reduced_t), pointer, intent(in) :: judge
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    select type (room)
    type is (condensed_room_t)
      call multiply(1.0_rk, self%data%free_opening, theta, 0.0_rk, room%free_opening)
      call balance_anchors(self%data, theta, room%free_opening)
      answer%n_iterations = 0
      call start_set(self%data, near, room)
      answer%reason = lcp_failed_ray
      if (near%nearest >= 1 .and. near%nearest <= size(self%data%reference_of_point)) &
        call solve_transformed(self, self%data%reference_of_point(near%nearest), theta, room, answer)
      if (answer%reason < 0) call solve_whole(self, room, answer)
      if (answer%reason == lcp_failed_ray .and. size(self%data%anchors) > 0) answer%reason = answer_failed_pulled_off
      if (answer%reason > 0) call take_forces(self, room, answer)
    end select
  end subroutine solve

  !> Loads that are in equilibrium but for rounding are so.
  pure subroutine balance_anchors(data, theta, opening)
    type(condensed_data_t), intent(in) :: data
    real(rk), intent(in) :: theta(:)
    real(rk), intent(inout) :: opening(:)
    integer :: i

    do i = 1, size(data%anchors)
      associate (row => data%anchors(i))
        if (abs(opening(row)) <= rounding * sum(abs(data%free_opening(row, :) * theta))) opening(row) = 0
      end associate
    end do
  end subroutine balance_anchors

  !> The set of the nearest training point; without one what penetrates, and with anchors all pairs, which hold the bodies.
  subroutine start_set(data, near, room)
    type(condensed_data_t), intent(in) :: data
    type(neighbors_t), intent(in) :: near
    type(condensed_room_t), intent(inout) :: room

    if (near%nearest >= 1 .and. near%nearest <= size(data%start_sets, 2)) then
      call unpack_bits(data%start_sets(:, near%nearest), room%start)
    else if (size(data%anchors) == 0) then
      room%start = room%free_opening < 0
    else
      room%start = .true.
      room%start(data%anchors) = .false.
    end if
  end subroutine start_set

  !> Through a principal pivot transform: the unknowns are the contacts that differ from the reference.
  subroutine solve_transformed(self, i_reference, theta, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    integer, intent(in) :: i_reference
    real(rk), contiguous, intent(in) :: theta(:)
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    integer :: i, n

    n = size(room%opening)
    call multiply(1.0_rk, self%transformed_opening(:, :, i_reference), theta, 0.0_rk, room%transformed)
    associate (in_reference => self%reference_sets(:, i_reference))
      room%start = room%start .neqv. in_reference
      call change_sets(self%data%transforms(:, (i_reference - 1) * n + 1:i_reference * n), room%transformed, room%start, &
        room%solution, room%workspace)
      room%start = room%start .neqv. in_reference
      call answer%take_solution(room%solution, answer_condensed)
      if (answer%reason < 0) return
      do i = 1, n
        answer%unknowns(i) = room%solution%lambda(i)
        if (in_reference(i)) answer%unknowns(i) = merge(0.0_rk, max(0.0_rk, room%workspace%w(i)), room%solution%lambda(i) > 0)
      end do
    end associate
  end subroutine solve_transformed

  !> By the methods for any problem, W factored anew.
  subroutine solve_whole(self, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    call solve_lcp(self%data%compliance, room%free_opening, room%start, room%solution, room%workspace)
    call answer%take_solution(room%solution, answer_condensed)
    answer%unknowns = room%solution%lambda
  end subroutine solve_whole

  !> Multipliers from the unknowns, and the openings w in room%opening.
  subroutine take_forces(self, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    integer :: i

    room%opening = room%free_opening
    call multiply(1.0_rk, self%data%compliance, answer%unknowns, 1.0_rk, room%opening)
    answer%multipliers = answer%unknowns
    do i = 1, size(self%data%anchors)
      associate (row => self%data%anchors(i))
        answer%multipliers(row) = merge(0.0_rk, max(0.0_rk, room%opening(row)) / self%data%scale, answer%unknowns(row) > 0)
      end associate
    end do
    answer%is_whole = .true.
    if (size(answer%multipliers_rid) /= size(answer%multipliers)) return
    answer%multipliers_rid = answer%multipliers
    answer%is_active = answer%multipliers > 0
  end subroutine take_forces

  subroutine fill_multipliers(self, answer, room, multipliers)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    class(room_t), intent(inout) :: room
    real(rk), intent(out) :: multipliers(:)

    multipliers = answer%multipliers
  end subroutine fill_multipliers

  subroutine fill_displacement(self, answer, displacement)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    call fill_condensed_displacement(self%data, answer%theta, answer%unknowns, displacement)
  end subroutine fill_displacement

  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = condensed_displacement_of_dof(self%data, answer%theta, answer%unknowns, dof)
  end function displacement_of_dof

  pure logical function has_whole_field(self, n_dofs)
    class(reduced_condensed_t), intent(in) :: self
    integer, intent(in) :: n_dofs

    has_whole_field = size(self%data%basis, 2) > 0 .or. size(self%data%exact_dofs) == n_dofs
  end function has_whole_field

  pure integer function displacement_source(self, dof) result(source)
    class(reduced_condensed_t), intent(in) :: self
    integer, intent(in) :: dof

    source = source_of_dof(self%data, dof)
  end function displacement_source

  pure function contact_rows(self) result(numbers)
    class(reduced_condensed_t), intent(in) :: self
    integer, allocatable :: numbers(:)
    integer :: i

    numbers = [(i, i=1, self%n_rows())]
  end function contact_rows

  pure integer function n_rows(self)
    class(reduced_condensed_t), intent(in) :: self

    n_rows = size(self%data%compliance, 1)
  end function n_rows

  !> It has no basis.
  pure integer function n_modes(self)
    class(reduced_condensed_t), intent(in) :: self

    n_modes = 0
  end function n_modes

  subroutine write(self, file, group, length, force)
    class(reduced_condensed_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call self%data%write(file, group, length, force)
  end subroutine write

  subroutine read(self, file, group, error)
    class(reduced_condensed_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call self%data%read(file, group, error)
  end subroutine read

  pure function describe(self) result(text)
    class(reduced_condensed_t), intent(in) :: self
    character(:), allocatable :: text

    text = line('  forces', 'exact on all ' // counted(self%n_rows(), 'contact pair'))
    text = text // line('  displacements', displacement_text(self%data))
    text = text // line('  pivot transforms', counted(size(self%data%reference_points), 'reference set'))
  end function describe

  !> Of which dofs there are displacements, and whether they are exact.
  pure function displacement_text(data) result(text)
    type(condensed_data_t), intent(in) :: data
    character(:), allocatable :: text

    text = 'none: contact forces only'
    if (size(data%exact_boundaries) > 0) then
      text = 'exact at the nodes of ' // join(data%exact_boundaries, ', ')
    else if (size(data%exact_dofs) > 0) then
      text = 'exact at all nodes'
    end if
    associate (n_modes => size(data%basis, 2))
      if (n_modes > 0 .and. size(data%exact_dofs) > 0) then
        text = text // ', by ' // counted(n_modes, 'mode') // ' elsewhere'
      else if (n_modes > 0) then
        text = 'by ' // counted(n_modes, 'mode')
      else if (size(data%exact_boundaries) > 0) then
        text = text // ', none elsewhere'
      end if
    end associate
  end function displacement_text

  pure logical function is_exact(self)
    class(reduced_condensed_t), intent(in) :: self

    is_exact = .true.
  end function is_exact

  pure logical function has_displacement(self)
    class(reduced_condensed_t), intent(in) :: self

    has_displacement = self%data%has_field()
  end function has_displacement

  !> [force*length] E = 1/2 lambda' W lambda + q' lambda. With anchors without their rows, and huge of forces that do not balance
  !> the loads.
  real(rk) function energy(self, theta, multipliers, opening)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: multipliers(:)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk) :: forces(size(multipliers))

    call multiply(1.0_rk, self%data%free_opening, theta, 0.0_rk, opening)
    forces = multipliers
    if (size(self%data%anchors) > 0) then
      energy = huge(energy)
      call balance_anchors(self%data, theta, opening)
      if (.not. self%bodies%are_balanced(opening, multipliers)) return
      forces(self%data%anchors) = 0
    end if
    call multiply(0.5_rk, self%data%compliance, forces, 1.0_rk, opening)
    energy = dot_product(forces, opening)
  end function energy

  !> W is positive definite.
  pure logical function can_certify(self)
    class(reduced_condensed_t), intent(in) :: self

    can_certify = self%bound%is_valid
  end function can_certify

  !> |lambda_r - lambda| in the norm of W is at most the bound of sig_contact_error_bound; it is |u(lambda_r) - u| in the norm of K.
  !>
  !> With anchors the norm is that of the elastic parts of the displacements, with closed anchors, and forces that do not balance
  !> the loads have no bound: infinite.
  subroutine certify(self, multipliers, is_own, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    logical, intent(in) :: is_own
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    real(rk) :: closing(size(self%free_rows)), forces(size(self%free_rows)), opening(size(self%free_rows))
    real(rk) :: size_of_answer, surplus

    select type (room)
    type is (condensed_room_t)
      call open_rows(self, multipliers, is_own, room, answer, closing, opening)
      forces = multipliers(self%free_rows)
      size_of_answer = max(sqrt(max(0.0_rk, dot_product(forces, closing))), smallest_share * self%data%largest_size)
      if (is_own .or. size(self%data%anchors) == 0) then
        answer%bound = self%bound%evaluate(forces, opening, exact * size_of_answer)
      else if (self%bodies%are_balanced(room%free_opening, multipliers)) then
        call self%bodies%settle(multipliers, opening, surplus)
        answer%bound = self%bound%evaluate(forces, opening, exact * size_of_answer, surplus)
      else
        answer%bound = huge(answer%bound)
      end if
      answer%relative_bound = huge(answer%relative_bound)
      if (answer%bound < huge(answer%bound)) answer%relative_bound = relative(answer%bound, size_of_answer)
    end select
  end subroutine certify

  !> What the forces open on the rows that are no anchors: with the place of the bodies as solved for, or else with closed anchors.
  subroutine open_rows(self, multipliers, is_own, room, answer, closing, opening)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    logical, intent(in) :: is_own
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(in) :: answer
    !> [length] W lambda
    real(rk), intent(out) :: closing(:)
    real(rk), intent(out) :: opening(:)
    real(rk) :: forces(size(multipliers))
    integer :: i

    if (.not. is_own) then
      call multiply(1.0_rk, self%data%free_opening, answer%theta, 0.0_rk, room%free_opening)
      call balance_anchors(self%data, answer%theta, room%free_opening)
      forces = multipliers
      forces(self%data%anchors) = 0
      room%opening = room%free_opening
      call multiply(1.0_rk, self%data%compliance, forces, 1.0_rk, room%opening)
    end if
    opening = room%opening(self%free_rows)
    closing = opening - room%free_opening(self%free_rows)
    if (.not. is_own) return
    do i = 1, size(self%data%anchors)
      associate (anchor => self%data%anchors(i))
        if (answer%unknowns(anchor) > 0) closing = closing - answer%unknowns(anchor) * self%data%compliance(self%free_rows, anchor)
      end associate
    end do
  end subroutine open_rows

  !> 0/0 is 0.
  pure real(rk) function relative(part, whole)
    real(rk), intent(in) :: part
    real(rk), intent(in) :: whole

    relative = 0
    if (part > 0) relative = part / max(whole, tiny(whole))
  end function relative
end module sig_reduced_condensed
