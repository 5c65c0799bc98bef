! SPDX-License-Identifier: BSD-3-Clause
!> Integration points of cells whose material flows (plasticity, creep), as a reduced model sees them: the strain at each point is a
!> sum of what the terms, the unknowns of the contact and the inelastic modes cause there.
!>
!> With s = C eps - sigma = C eps_in, the stress that the inelastic strain takes away, the sums over the points
!>
!>     sum_g w_g E_i,g' s_g
!>
!> are the work of the inelastic strain on the strain E_i of a mode, of a contact force or of a term.
module sig_flow_points
  use sig_compressed_matrix, only: compressed_matrix_t
  use sig_dense_kernels, only: add_few_columns, add_product, add_transposed_product, multiply, multiply_transpose
  use sig_elasticity, only: n_stresses
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_material_law, only: material_law_t
  use sig_missing_parts, only: fill_missing
  use sig_shape_checks, only: is_matrix
  implicit none(type, external)
  private
  public :: flow_law_t, flow_points_t, flow_room_t, most_states

  !> The law of a material that flows, and its elastic part.
  type :: flow_law_t
    class(material_law_t), allocatable :: law
    !> [force/length**2] C, shape (n_stresses, n_stresses)
    real(rk) :: hooke(n_stresses, n_stresses) = 0
  end type flow_law_t

  type :: flow_points_t
    !> components of the strain that the model has, 1-based among xx, yy, zz, xy, yz, xz; shape (n_strains)
    integer, allocatable :: components(:)
    !> number of the material of each point, 1-based; shape (n_points)
    integer, allocatable :: materials(:)
    !> [length**3, length**2 in the plane] volume of each point, or its weight where points stand for others; shape (n_points)
    real(rk), allocatable :: weights(:)
    !> [-] strain of each term with the value 1, of each unknown [1/force], and of each inelastic mode with the amplitude 1; shapes
    !> (n_strains * n_points, n_terms), (., n_rows) and (., n_modes). The components of a point follow each other.
    real(rk), allocatable :: of_terms(:, :)
    real(rk), allocatable :: of_contact(:, :)
    real(rk), allocatable :: of_modes(:, :)
    !> where it is not empty, it has the strain of each unknown, and of_contact has no columns
    type(compressed_matrix_t) :: contact_blocks
    !> [-] imposed strains of all components per unit of their terms, shears as angles; shape (n_stresses * n_points,
    !> n_strain_terms)
    real(rk), allocatable :: imposed(:, :)
    !> [degree] parts of the temperature (sig_flow_properties), shape (n_points, n_parts)
    real(rk), allocatable :: temperatures(:, :)
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: write
    procedure :: read
    procedure :: n_points
    procedure :: create_room
    procedure :: find_flaw
    procedure :: find_strains
    procedure :: impose
    procedure :: update
    procedure :: apply_laws
    procedure :: work_on_modes
    procedure :: work_on_contact
    procedure :: add_contact_strains
    procedure :: change_of_work
  end type flow_points_t

  !> Work arrays of one thread, and the states of the points.
  type :: flow_room_t
    !> at the last time, and of the last update; shape (n_most_state, n_points)
    real(rk), allocatable :: old_states(:, :)
    real(rk), allocatable :: states(:, :)
    !> properties of the law of each point; the caller sets them. shape (n_most_properties, n_points)
    real(rk), allocatable :: properties(:, :)
    !> of the last update: [force/length**2] stress, shape (n_stresses, n_points), and [force, force/length] weight times s of the
    !> components that the model has, shape (n_strains * n_points)
    real(rk), allocatable :: stresses(:, :)
    real(rk), allocatable :: taken(:)
    !> [force, force/length] weight times (C - C_T) of these components; shape (n_strains, n_strains, n_points)
    real(rk), allocatable :: softening(:, :, :)
    !> [-] total strains, shape (n_strains * n_points), and imposed ones, shape (n_stresses * n_points)
    real(rk), allocatable :: strains(:)
    real(rk), allocatable, private :: imposed(:)
  end type flow_room_t

contains

  !> Allocates the arrays that are not allocated, with size 0.
  pure subroutine complete(self, n_terms, n_rows, n_modes)
    class(flow_points_t), intent(inout) :: self
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_modes

    call fill_missing(self%components)
    call fill_missing(self%materials)
    call fill_missing(self%weights)
    if (.not. allocated(self%of_terms)) allocate (self%of_terms(0, n_terms))
    if (.not. allocated(self%of_contact)) allocate (self%of_contact(0, n_rows))
    call self%contact_blocks%complete()
    if (.not. allocated(self%of_modes)) allocate (self%of_modes(0, n_modes))
    if (.not. allocated(self%imposed)) allocate (self%imposed(n_stresses * size(self%weights), 0))
    call fill_missing(self%temperatures, size(self%weights))
  end subroutine complete

  !> Returns the name of an array whose shape or values do not fit; empty when all fit. Requires: complete.
  pure function mismatch(self, n_materials, n_parts, n_strain_terms, n_terms, n_rows, n_modes) result(name)
    class(flow_points_t), intent(in) :: self
    integer, intent(in) :: n_materials
    !> of the temperature
    integer, intent(in) :: n_parts
    integer, intent(in) :: n_strain_terms
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_modes
    character(:), allocatable :: name
    integer :: i

    name = ''
    associate (n => size(self%weights), n_strains => size(self%components))
      if (any(self%components < 1 .or. self%components > n_stresses)) name = 'components'
      do i = 2, n_strains
        if (self%components(i) <= self%components(i - 1)) name = 'components'
      end do
      if (size(self%materials) /= n .or. any(self%materials < 1 .or. self%materials > n_materials)) name = 'materials'
      if (.not. all(self%weights >= 0 .and. self%weights <= huge(self%weights))) name = 'weights'
      if (.not. is_matrix(self%of_terms, n_strains * n, n_terms)) name = 'of_terms'
      if (.not. is_matrix(self%of_contact, n_strains * n, merge(n_rows, 0, self%contact_blocks%is_empty()))) name = 'of_contact'
      if (.not. self%contact_blocks%fits(n_strains * n, n_rows)) name = 'contact_blocks'
      if (.not. is_matrix(self%of_modes, n_strains * n, n_modes)) name = 'of_modes'
      if (.not. is_matrix(self%imposed, n_stresses * n, n_strain_terms)) name = 'imposed'
      if (.not. is_matrix(self%temperatures, n, n_parts)) name = 'temperatures'
    end associate
  end function mismatch

  !> Writes the points to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(flow_points_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/components', self%components, description='components of strains, 1 to 6: xx, yy, zz, xy, yz, xz')
    call file%write(group // '/materials', self%materials, description='material of each point, 1-based')
    call file%write(group // '/weights', self%weights, description='volume of each point, or its share of the volume')
    call file%write(group // '/of_terms', self%of_terms, description='strain of each term')
    call file%write(group // '/of_contact', self%of_contact, '1/(' // force // ')', 'strain of a unit contact force')
    call file%write(group // '/contact_row_order', self%contact_blocks%row_order, description= &
      'strain of each ordered row of the compressed strains of contact forces, 1-based')
    call file%write(group // '/contact_column_order', self%contact_blocks%column_order, description= &
      'contact of each ordered column of these, 1-based')
    call file%write(group // '/contact_blocks', self%contact_blocks%blocks, description= &
      'first and last ordered row and column (1-based) and rank of each block, a block per row')
    call file%write(group // '/contact_values', self%contact_blocks%values, '1/(' // force // ')', 'blocks one after the ' // &
      'other, column by column: the block if its rank is 0, else its left and right factor')
    call file%write(group // '/of_modes', self%of_modes, '1/sqrt(' // force // '*' // length // ')', 'strain of each mode')
    call file%write(group // '/imposed', self%imposed, description='imposed strain of each of its terms, all components')
    call file%write(group // '/temperatures', self%temperatures, description='values of each part of the temperature')
  end subroutine write

  !> Reads what `write` writes. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(flow_points_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/components', self%components, error)
    call file%read(group // '/materials', self%materials, error)
    call file%read(group // '/weights', self%weights, error)
    call file%read(group // '/of_terms', self%of_terms, error)
    call file%read(group // '/of_contact', self%of_contact, error)
    call file%read(group // '/contact_row_order', self%contact_blocks%row_order, error)
    call file%read(group // '/contact_column_order', self%contact_blocks%column_order, error)
    call file%read(group // '/contact_blocks', self%contact_blocks%blocks, error)
    call file%read(group // '/contact_values', self%contact_blocks%values, error)
    call file%read(group // '/of_modes', self%of_modes, error)
    call file%read(group // '/imposed', self%imposed, error)
    call file%read(group // '/temperatures', self%temperatures, error)
  end subroutine read

  pure integer function n_points(self)
    class(flow_points_t), intent(in) :: self

    n_points = size(self%weights)
  end function n_points

  !> Returns how many numbers the state of a point has, with room for that of any law.
  pure integer function most_states(laws)
    type(flow_law_t), intent(in) :: laws(:)
    integer :: i

    most_states = maxval([0, (laws(i)%law%n_state, i=1, size(laws))])
  end function most_states

  !> Makes the work arrays of one thread, in the virgin state.
  pure subroutine create_room(self, laws, room)
    class(flow_points_t), intent(in) :: self
    type(flow_law_t), intent(in) :: laws(:)
    type(flow_room_t), intent(out) :: room
    integer :: i, n_properties

    n_properties = maxval([0, (laws(i)%law%n_properties(), i=1, size(laws))])
    associate (n => self%n_points(), n_strains => size(self%components), n_state => most_states(laws))
      allocate (room%old_states(n_state, n), room%states(n_state, n), room%properties(n_properties, n), &
        room%stresses(n_stresses, n), room%taken(n_strains * n), room%softening(n_strains, n_strains, n), &
        room%strains(n_strains * n), room%imposed(n_stresses * n), source=0.0_rk)
    end associate
  end subroutine create_room

  !> Finds a property that is not finite or out of its range.
  pure function find_flaw(self, laws, room) result(flaw)
    class(flow_points_t), intent(in) :: self
    type(flow_law_t), intent(in) :: laws(:)
    !> in: properties
    type(flow_room_t), intent(in) :: room
    !> numbers of the material and of the property of its law, 1-based, at the first such point; 0: there is none
    integer :: flaw(2)
    integer :: i

    do i = 1, self%n_points()
      flaw(1) = self%materials(i)
      associate (law => laws(flaw(1))%law)
        flaw(2) = law%bad_property(room%properties(:law%n_properties(), i))
      end associate
      if (flaw(2) > 0) return
    end do
    flaw = 0
  end function find_flaw

  !> Computes the strains [-] by terms, unknowns and amplitudes, in which imposed strains are contained.
  subroutine find_strains(self, theta, unknowns, amplitudes, strains)
    class(flow_points_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] shape (n_rows)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [sqrt(force*length)] shape (n_modes)
    real(rk), contiguous, intent(in) :: amplitudes(:)
    !> shape (n_strains * n_points)
    real(rk), contiguous, intent(inout) :: strains(:)

    call multiply(1.0_rk, self%of_terms, theta, 0.0_rk, strains)
    if (self%contact_blocks%is_empty()) then
      call add_few_columns(self%of_contact, unknowns, strains)
    else
      call self%contact_blocks%add_product(1.0_rk, unknowns, strains)
    end if
    call add_few_columns(self%of_modes, amplitudes, strains)
  end subroutine find_strains

  !> Computes the imposed strains of a time.
  subroutine impose(self, strain_theta, room)
    class(flow_points_t), intent(in) :: self
    !> values of the terms of imposed strains, shape (n_strain_terms)
    real(rk), contiguous, intent(in) :: strain_theta(:)
    type(flow_room_t), intent(inout) :: room

    call multiply(1.0_rk, self%imposed, strain_theta, 0.0_rk, room%imposed)
  end subroutine impose

  !> Computes strains, and from them stresses and states at the end of a step.
  subroutine update(self, laws, theta, strain_theta, unknowns, amplitudes, dt, room, is_solved)
    class(flow_points_t), intent(in) :: self
    type(flow_law_t), intent(in) :: laws(:)
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> values of the terms of imposed strains, shape (n_strain_terms)
    real(rk), contiguous, intent(in) :: strain_theta(:)
    !> [force] shape (n_rows)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [sqrt(force*length)] shape (n_modes)
    real(rk), contiguous, intent(in) :: amplitudes(:)
    !> [time] of the step
    real(rk), intent(in) :: dt
    !> in: old_states and properties
    type(flow_room_t), intent(inout) :: room
    !> whether the laws have an answer at all points
    logical, intent(out) :: is_solved

    call self%impose(strain_theta, room)
    call self%find_strains(theta, unknowns, amplitudes, room%strains)
    call self%apply_laws(laws, dt, room, is_solved)
  end subroutine update

  !> Computes stresses and states at the end of a step from strains.
  subroutine apply_laws(self, laws, dt, room, is_solved)
    class(flow_points_t), intent(in) :: self
    type(flow_law_t), intent(in) :: laws(:)
    !> [time] of the step
    real(rk), intent(in) :: dt
    !> in: strains, imposed strains (impose), old_states and properties
    type(flow_room_t), intent(inout) :: room
    !> whether the laws have an answer at all points
    logical, intent(out) :: is_solved
    real(rk) :: strain(n_stresses), stress(n_stresses), tangent(n_stresses, n_stresses)
    integer :: i, k
    logical :: is_point_solved

    is_solved = .true.
    associate (n => size(self%components), c => self%components)
      do i = 1, self%n_points()
        strain = -room%imposed(n_stresses * (i - 1) + 1:n_stresses * i)
        strain(c) = strain(c) + room%strains(n * (i - 1) + 1:n * i)
        associate (law => laws(self%materials(i))%law, hooke => laws(self%materials(i))%hooke)
          call law%update(strain, dt, room%properties(:law%n_properties(), i), room%old_states(:law%n_state, i), stress, &
            room%states(:law%n_state, i), tangent, is_point_solved)
          is_solved = is_solved .and. is_point_solved
          room%stresses(:, i) = stress
          do k = 1, n
            room%taken(n * (i - 1) + k) = self%weights(i) * (dot_product(hooke(:, c(k)), strain) - stress(c(k)))
          end do
          room%softening(:, :, i) = self%weights(i) * (hooke(c, c) - tangent(c, c))
        end associate
      end do
    end associate
  end subroutine apply_laws

  !> Computes the work of the inelastic strains of the last update on the strain of each mode [sqrt(force*length)]: with all points
  !> of a body these are the amplitudes of the displacement that the inelastic strains cause.
  subroutine work_on_modes(self, room, work)
    class(flow_points_t), intent(in) :: self
    type(flow_room_t), intent(in) :: room
    !> shape (n_modes)
    real(rk), contiguous, intent(inout) :: work(:)

    call multiply_transpose(1.0_rk, self%of_modes, room%taken, 0.0_rk, work)
  end subroutine work_on_modes

  !> Computes the work of the inelastic strains of the last update on the strain of each unit contact force [length]: with all
  !> points of a body, by how much these strains open each contact.
  subroutine work_on_contact(self, room, work)
    class(flow_points_t), intent(in) :: self
    type(flow_room_t), intent(in) :: room
    !> shape (n_rows)
    real(rk), contiguous, intent(inout) :: work(:)

    if (self%contact_blocks%is_empty()) then
      call multiply_transpose(1.0_rk, self%of_contact, room%taken, 0.0_rk, work)
    else
      work = 0
      call self%contact_blocks%add_transposed_product(room%taken, work)
    end if
  end subroutine work_on_contact

  !> Adds the strains of unknowns to strains. Requires: of_contact has the strains of contact forces.
  subroutine add_contact_strains(self, unknowns, strains)
    class(flow_points_t), intent(in) :: self
    !> [force per any unit], shape (n_rows, n_columns)
    real(rk), contiguous, intent(in) :: unknowns(:, :)
    !> [- per the same unit], shape (n_strains * n_points, n_columns)
    real(rk), contiguous, intent(inout) :: strains(:, :)

    call add_product(1.0_rk, self%of_contact, unknowns, strains)
  end subroutine add_contact_strains

  !> Computes by how much work_on_modes changes with the amplitudes, with which strains change by strain_changes: shape
  !> (n_modes, n_modes).
  subroutine change_of_work(self, room, strain_changes, change)
    class(flow_points_t), intent(in) :: self
    type(flow_room_t), intent(in) :: room
    real(rk), contiguous, intent(in) :: strain_changes(:, :)
    real(rk), contiguous, intent(out) :: change(:, :)
    real(rk), allocatable :: taken(:, :)
    integer :: first, i, j, k

    allocate (taken(size(strain_changes, 1), size(strain_changes, 2)), source=0.0_rk)
    associate (n => size(self%components))
      do j = 1, size(taken, 2)
        do i = 1, self%n_points()
          first = n * (i - 1)
          do k = 1, n
            taken(first + 1:first + n, j) = taken(first + 1:first + n, j) + room%softening(:, k, i) * strain_changes(first + k, j)
          end do
        end do
      end do
    end associate
    change = 0
    call add_transposed_product(1.0_rk, self%of_modes, taken, change)
  end subroutine change_of_work
end module sig_flow_points
