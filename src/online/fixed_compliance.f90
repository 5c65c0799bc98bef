! SPDX-License-Identifier: BSD-3-Clause
!> W and q of a problem whose stiffness does not depend on the parameters: W is one matrix, and q and the displacement are sums of
!> terms. Training makes the data and a file keeps them.
!>
!>     0 <= z, W z + free_opening theta >= 0, complementary;  u = G theta' - H z with the leading terms theta'
module sig_fixed_compliance
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t
  use sig_compliance, only: compliance_point_t, compliance_t, round_work
  use sig_contact_field, only: contact_field_t
  use sig_dense_kernels, only: add_few_columns
  use sig_description_line, only: line
  use sig_errors, only: error_t
  use sig_gradient, only: gradient_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t
  use sig_lcp_rounding, only: drop_small_forces => drop_rounding, lcp_sizes_t
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_model_data, only: model_sizes_t
  use sig_pivot_sets, only: pivot_sets_t, transform_scale
  use sig_rounding, only: rounding
  use sig_shape_checks, only: is_matrix, place_in_ascending
  use sig_text, only: counted
  implicit none(type, external)
  private
  public :: fixed_compliance_t

  type, extends(compliance_t) :: fixed_compliance_t
    !> [length/force] W, shape (n_multipliers, n_multipliers); symmetric without anchors
    real(rk), allocatable :: compliance(:, :)
    !> [length per unit of theta] D - B G, shape (n_multipliers, n_terms)
    real(rk), allocatable :: free_opening(:, :)
    !> [length per unit of theta] G of the leading terms, as the other terms cause no displacement; for the exact dofs or, where
    !> `field` is there, for all dofs; shape (n_exact or n_dofs, n_driving_terms)
    real(rk), allocatable :: free_response(:, :)
    !> [length/force] H of the exact dofs, shape (n_exact, n_multipliers)
    real(rk), allocatable :: contact_response(:, :)
    !> H z of the other dofs, or nothing
    type(contact_field_t) :: field
    !> [force*length per unit of theta squared] G'K G of the leading terms, shape (n_loads, n_loads)
    real(rk), allocatable :: free_energy(:, :)
    !> [length per unit of theta] H'K G of the leading terms, shape (n_multipliers, n_loads); zero in the rows of anchors
    real(rk), allocatable :: shared_energy(:, :)
    !> W and q, transformed
    type(pivot_sets_t) :: pivots
    !> of W and q, from `prepare`
    type(lcp_sizes_t), private :: sizes
    !> terms of q that open one row alone, such as the gaps of a moving obstacle, where most terms do: term, row and [length per
    !> unit of theta] opening of each; and the other terms. Not allocated where most terms open many rows
    integer, allocatable, private :: lone_terms(:), lone_rows(:), other_terms(:)
    real(rk), allocatable, private :: lone_openings(:)
  contains
    procedure :: kind => kind_of
    procedure :: complete
    procedure :: mismatch
    procedure :: write
    procedure :: read
    procedure :: describe
    procedure :: n_rows
    procedure :: has_modes
    procedure :: is_fixed
    procedure :: prepare
    procedure :: solve_near
    procedure :: evaluate
    procedure :: matrix
    procedure :: opening_terms
    procedure :: drop_rounding
    procedure :: change_openings
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: displace
    procedure :: displacement_of
    procedure :: change_field
    procedure :: anchor_motion
    procedure :: size_of_field
    procedure :: field_error
  end type fixed_compliance_t

contains

  pure function kind_of(self) result(text)
    class(fixed_compliance_t), intent(in) :: self
    character(:), allocatable :: text

    text = 'condensed'
  end function kind_of

  !> Allocates each array of this type and of its base type that is not allocated: lists with size 0, matrices without columns or
  !> without rows. `sizes` gives the other extent of a matrix, except for free_response, which gets the shape (0, 0).
  pure subroutine complete(self, sizes)
    class(fixed_compliance_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call self%complete_shared(sizes)
    call fill_missing(self%compliance, sizes%n_multipliers)
    call fill_missing(self%free_opening, sizes%n_multipliers)
    if (.not. allocated(self%free_response)) allocate (self%free_response(0, 0))
    if (.not. allocated(self%contact_response)) allocate (self%contact_response(0, sizes%n_multipliers))
    call self%field%complete(sizes%n_dofs, sizes%n_multipliers)
    if (.not. allocated(self%free_energy)) allocate (self%free_energy(0, 0))
    call fill_missing(self%shared_energy, sizes%n_multipliers)
    call self%pivots%complete(sizes%n_multipliers)
  end subroutine complete

  !> Returns the name of an array of this type or of its base type whose shape or values do not fit the model, one of them if there
  !> are several; empty when all fit. Requires: complete.
  pure function mismatch(self, sizes) result(name)
    class(fixed_compliance_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = self%shared_mismatch(sizes)
    if (.not. is_matrix(self%compliance, sizes%n_multipliers, sizes%n_multipliers)) name = 'compliance'
    if (.not. is_matrix(self%free_opening, sizes%n_multipliers, sizes%n_terms)) name = 'free_opening'
    if (len(name) == 0) name = self%pivots%mismatch(sizes%n_multipliers, size(self%start_sets, 2))
    if (len(name) == 0) name = field_mismatch(self, sizes)
  end function mismatch

  !> Returns the name of an array for displacements whose shape does not fit the model or whose values are not finite; empty when
  !> all fit.
  pure function field_mismatch(self, sizes) result(name)
    class(fixed_compliance_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name
    integer :: n_responses

    name = ''
    associate (exact => self%exact_dofs, n_loads => size(self%free_energy, 2))
      n_responses = merge(sizes%n_dofs, size(exact), self%field%is_there())
      if (.not. is_matrix(self%free_response, n_responses, min(sizes%n_terms, size(self%free_response, 2)))) name = 'free_response'
      if (.not. is_matrix(self%contact_response, size(exact), sizes%n_multipliers)) name = 'contact_response'
      if (.not. is_matrix(self%free_energy, min(n_loads, sizes%n_terms), n_loads)) name = 'free_energy'
      if (.not. is_matrix(self%shared_energy, sizes%n_multipliers, n_loads)) name = 'shared_energy'
      if (.not. ieee_is_finite(self%largest_field)) name = 'largest_field'
      if (.not. (ieee_is_finite(self%least_eigenvalue) .and. self%least_eigenvalue >= 0)) name = 'least_eigenvalue'
    end associate
    if (len(name) == 0) name = self%field%mismatch(sizes%n_dofs, sizes%n_multipliers, size(self%anchors))
  end function field_mismatch

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(fixed_compliance_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call self%write_shared(file, group, length, force)
    call self%write_anchors(file, group, length, force)
    call file%write(group // '/compliance', self%compliance, length // '/(' // force // ')', &
      'opening of each contact under a unit contact force of each contact; rows and columns of anchors: see scale')
    call file%write(group // '/free_opening', self%free_opening, length, 'gap without contact forces, a term per row; ' // &
      'of an anchor: see scale')
    call file%write(group // '/free_response', self%free_response, length, &
      'displacement without contact, a leading term per row; of the exact dofs, or of all where field is there')
    call file%write(group // '/contact_response', self%contact_response, length // '/(' // force // ')', &
      'minus the displacement of the exact dofs under a unit contact force, a contact per row; of an anchor: see scale')
    call self%field%write(file, group // '/field', length, force)
    call file%write(group // '/free_energy', self%free_energy, force // '*' // length, &
      'work of the forces of each term on the displacement of each term, without contact')
    call file%write(group // '/shared_energy', self%shared_energy, length, &
      'work of a unit contact force on minus the displacement of each term that loads cause, a term per row')
    call self%pivots%write(file, group)
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(fixed_compliance_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call self%read_shared(file, group, error)
    call self%read_anchors(file, group, error)
    call file%read(group // '/compliance', self%compliance, error)
    call file%read(group // '/free_opening', self%free_opening, error)
    call file%read(group // '/free_response', self%free_response, error)
    call file%read(group // '/contact_response', self%contact_response, error)
    call self%field%read(file, group // '/field', error)
    call file%read(group // '/free_energy', self%free_energy, error)
    call file%read(group // '/shared_energy', self%shared_energy, error)
    call self%pivots%read(file, group, error)
  end subroutine read

  pure function describe(self) result(text)
    class(fixed_compliance_t), intent(in) :: self
    character(:), allocatable :: text

    text = line('  forces', 'exact on all ' // counted(self%n_rows(), 'contact row'))
    text = text // line('  displacements', self%displacement_text(self%field%describe()))
    text = text // line('  pivot transforms', counted(size(self%pivots%reference_points), 'reference set'))
  end function describe

  pure integer function n_rows(self)
    class(fixed_compliance_t), intent(in) :: self

    n_rows = size(self%compliance, 1)
  end function n_rows

  !> Whether modes or compressed responses give the displacement of the dofs that are not exact.
  pure logical function has_modes(self)
    class(fixed_compliance_t), intent(in) :: self

    has_modes = self%field%is_there()
  end function has_modes

  pure logical function is_fixed(self)
    class(fixed_compliance_t), intent(in) :: self

    is_fixed = .true.
  end function is_fixed

  !> Measures W and q, and transforms q for the references.
  subroutine prepare(self)
    class(fixed_compliance_t), intent(inout) :: self

    call self%sizes%create(self%compliance, self%free_opening)
    call find_lone_terms(self)
    call self%pivots%prepare(transform_scale(self%compliance), self%free_opening, self%start_sets)
  end subroutine prepare

  !> Finds the terms that open one row alone, if these are most of them.
  subroutine find_lone_terms(self)
    type(fixed_compliance_t), intent(inout) :: self
    integer :: n_opened(size(self%free_opening, 2)), t

    if (allocated(self%lone_terms)) deallocate (self%lone_terms, self%lone_rows, self%other_terms, self%lone_openings)
    n_opened = count(abs(self%free_opening) > 0, dim=1)
    if (2 * count(n_opened == 1) <= size(n_opened)) return
    self%lone_terms = pack([(t, t=1, size(n_opened))], n_opened == 1)
    self%other_terms = pack([(t, t=1, size(n_opened))], n_opened > 1)
    self%lone_rows = [(maxloc(abs(self%free_opening(:, self%lone_terms(t))), dim=1), t=1, size(self%lone_terms))]
    self%lone_openings = [(self%free_opening(self%lone_rows(t), self%lone_terms(t)), t=1, size(self%lone_terms))]
  end subroutine find_lone_terms

  !> Computes the sum of the terms, self%free_opening theta.
  subroutine add_up_terms(self, theta, opening)
    type(fixed_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(inout) :: opening(:)
    integer :: i, k

    if (.not. allocated(self%lone_terms)) then
      call multiply(1.0_rk, self%free_opening, theta, 0.0_rk, opening)
      return
    end if
    opening = 0
    do i = 1, size(self%other_terms)
      associate (t => self%other_terms(i))
        do k = 1, size(opening)
          opening(k) = opening(k) + theta(t) * self%free_opening(k, t)
        end do
      end associate
    end do
    do i = 1, size(self%lone_terms)
      associate (k => self%lone_rows(i))
        opening(k) = opening(k) + theta(self%lone_terms(i)) * self%lone_openings(i)
      end associate
    end do
  end subroutine add_up_terms

  !> Solves by the pivot transform of the reference of a training point, if there is one.
  subroutine solve_near(self, nearest, theta, start, point, solution, workspace, unknowns, is_tried)
    class(fixed_compliance_t), intent(in) :: self
    integer, intent(in) :: nearest
    real(rk), contiguous, intent(in) :: theta(:)
    logical, contiguous, intent(inout) :: start(:)
    type(compliance_point_t), intent(inout) :: point
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk), intent(inout) :: unknowns(:)
    logical, intent(out) :: is_tried
    integer :: i_reference

    i_reference = self%pivots%reference_near(nearest)
    is_tried = i_reference > 0
    if (is_tried) call self%pivots%solve(i_reference, theta, start, point%rows, solution, workspace, unknowns)
  end subroutine solve_near

  !> Computes q = self%free_opening theta. At an anchor it becomes exactly zero if |q| is at most 1e-12 of the sum of the absolute
  !> values of its terms.
  subroutine evaluate(self, theta, point, is_valid)
    class(fixed_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(inout) :: point
    logical, intent(out) :: is_valid
    integer :: i

    is_valid = .true.
    call add_up_terms(self, theta, point%opening)
    do i = 1, size(self%anchors)
      associate (row => self%anchors(i))
        if (abs(point%opening(row)) <= rounding * sum(abs(self%free_opening(row, :) * theta))) point%opening(row) = 0
      end associate
    end do
  end subroutine evaluate

  function matrix(self, point)
    class(fixed_compliance_t), target, intent(in) :: self
    type(compliance_point_t), target, intent(in) :: point
    real(rk), pointer, contiguous :: matrix(:, :)

    matrix => self%compliance
  end function matrix

  function opening_terms(self, theta, point) result(terms)
    class(fixed_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    real(rk), allocatable :: terms(:)

    terms = matmul(abs(self%free_opening), abs(theta))
  end function opening_terms

  subroutine drop_rounding(self, theta, point, unknowns, forces)
    class(fixed_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(inout) :: forces(:)

    call drop_small_forces(self%sizes, self%compliance, self%free_opening, theta, self%anchors, self%scale, unknowns, forces)
  end subroutine drop_rounding

  subroutine change_openings(self, point, theta, theta_change, unknowns, changes)
    class(fixed_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), contiguous, intent(inout) :: changes(:)

    call multiply(1.0_rk, self%free_opening, theta_change, 0.0_rk, changes)
    call round_work(self%anchors, matmul(abs(self%free_opening(self%anchors, :)), abs(theta_change)), changes)
  end subroutine change_openings

  subroutine fill_displacement(self, answer, displacement)
    class(fixed_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    call self%displace(answer%theta, answer%unknowns, displacement)
  end subroutine fill_displacement

  !> Computes u = G theta - H z of all dofs; NaN for dofs of which there is none. It is linear in theta and z, so that their changes
  !> give its change.
  subroutine displace(self, theta, unknowns, displacement)
    class(fixed_compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: exact(size(self%exact_dofs))

    associate (leading => theta(:size(self%free_response, 2)))
      if (self%has_modes()) then
        call multiply(1.0_rk, self%free_response, leading, 0.0_rk, displacement)
        exact = displacement(self%exact_dofs)
        call self%field%subtract_from(self%anchors, unknowns, displacement)
      else
        displacement = ieee_value(1.0_rk, ieee_quiet_nan)
        call multiply(1.0_rk, self%free_response, leading, 0.0_rk, exact)
      end if
    end associate
    call multiply(-1.0_rk, self%contact_response, unknowns, 1.0_rk, exact)
    displacement(self%exact_dofs) = exact
  end subroutine displace

  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(fixed_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = self%displacement_of(answer%theta, answer%unknowns, dof)
  end function displacement_of_dof

  !> As displace, for one dof.
  pure real(rk) function displacement_of(self, theta, unknowns, dof) result(displacement)
    class(fixed_compliance_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: unknowns(:)
    integer, intent(in) :: dof
    integer :: i_exact

    i_exact = place_in_ascending(self%exact_dofs, dof)
    associate (leading => theta(:size(self%free_response, 2)), has_modes => self%has_modes())
      if (i_exact == 0 .and. .not. has_modes) then
        displacement = ieee_value(1.0_rk, ieee_quiet_nan)
        return
      end if
      displacement = dot_product(self%free_response(merge(dof, i_exact, has_modes), :), leading)
    end associate
    if (i_exact > 0) then
      displacement = displacement - dot_product(self%contact_response(i_exact, :), unknowns)
    else
      displacement = displacement - self%field%dof_value(self%anchors, unknowns, dof)
    end if
  end function displacement_of

  subroutine change_field(self, answer, gradient, i_parameter, dofs, changes)
    class(fixed_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    real(rk), allocatable :: field(:)
    integer :: i

    associate (theta => gradient%theta(:, i_parameter), unknowns => gradient%unknowns(:, i_parameter))
      if (self%field%is_there() .and. size(dofs) > 1) then
        ! a row of compressed responses costs a search
        allocate (field(size(self%field%motions, 1)))
        call self%displace(theta, unknowns, field)
        changes = field(dofs)
      else
        changes = [(self%displacement_of(theta, unknowns, dofs(i)), i=1, size(dofs))]
      end if
    end associate
  end subroutine change_field

  pure function anchor_motion(self, dof) result(motion)
    class(fixed_compliance_t), intent(in) :: self
    integer, intent(in) :: dof
    real(rk), allocatable :: motion(:)
    integer :: i

    allocate (motion(size(self%anchors)), source=0.0_rk)
    i = place_in_ascending(self%exact_dofs, dof)
    if (i > 0) then
      motion = self%contact_response(i, self%anchors) / self%scale
    else if (self%has_modes()) then
      motion = self%field%motion_of_dof(dof) / self%scale
    end if
  end function anchor_motion

  !> Returns |u|_K of u = G theta - H z:
  !>
  !>     |u|_K^2 = theta' G'K G theta - 2 z' H'K G theta + z'C z
  real(rk) function size_of_field(self, theta, unknowns, energy, point) result(size_of)
    class(fixed_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point
    real(rk) :: square, of_terms(size(self%free_energy, 1)), of_contacts(size(unknowns))

    of_terms = 0
    of_contacts = 0
    associate (loads => theta(:size(self%free_energy, 2)))
      call add_few_columns(self%free_energy, loads, of_terms)
      call add_few_columns(self%shared_energy, loads, of_contacts)
      square = energy + dot_product(loads, of_terms) - 2 * dot_product(unknowns, of_contacts)
    end associate
    size_of = sqrt(max(0.0_rk, square))
  end function size_of_field

  real(rk) function field_error(self, theta, unknowns, energy, point)
    class(fixed_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point

    field_error = self%field%error_of(unknowns, energy)
  end function field_error
end module sig_fixed_compliance
