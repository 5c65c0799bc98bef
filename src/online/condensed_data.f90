! SPDX-License-Identifier: BSD-3-Clause
!> The data of a condensed model: the full-order problem condensed to its contacts. Training makes them and a file keeps them.
module sig_condensed_data
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_contact_field, only: contact_field_t
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_reduced, only: model_sizes_t
  use sig_reduced_exact, only: reduced_exact_t
  use sig_rounding, only: rounding
  use sig_shape_checks, only: are_indices, is_matrix
  implicit none(type, external)
  private
  public :: condensed_data_t

  !> 0 <= z, W z + free_opening theta >= 0, complementary; u = G theta' - H z with the leading terms theta'.
  !>
  !> z are the multipliers. Anchors are contacts that are taken as closed to hold bodies that only contact holds. For an anchor the
  !> unknown is its opening over `scale` instead of its multiplier, and the complementary value is its multiplier times `scale`
  !> instead of its opening.
  type, abstract, extends(reduced_exact_t) :: condensed_data_t
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
    !> rows that are anchors, 1-based among the multipliers
    integer, allocatable :: anchors(:)
    !> [length/force] scale of the anchors
    real(rk) :: scale = 1
    !> [sqrt(force*length)] largest size of the forces in training, in the norm of W
    real(rk) :: largest_size = 0
    !> [sqrt(force*length)] largest size of the displacement in training, in the norm of the stiffness
    real(rk) :: largest_field = 0
    !> training points whose active sets have a principal pivot transform, shape (n_references)
    integer, allocatable :: reference_points(:)
    !> number of the reference nearest to each training point's set, 1-based; shape (n_points), or none
    integer, allocatable :: reference_of_point(:)
    !> the transforms of W / transform_scale side by side, shape (n_multipliers, n_multipliers * n_references)
    real(rk), allocatable :: transforms(:, :)
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: write
    procedure :: read
    procedure :: n_rows
    procedure :: transform_scale
    procedure :: has_modes
    procedure :: open_freely
    procedure :: size_of_field
  end type condensed_data_t

contains

  !> Allocates each array of this type and of its base type that is not allocated: lists with size 0, matrices without columns or
  !> without rows. `sizes` gives the other extent of a matrix, except for free_response, which gets the shape (0, 0).
  pure subroutine complete(self, sizes)
    class(condensed_data_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call self%complete_shared(sizes)
    call fill_missing(self%compliance, sizes%n_multipliers)
    call fill_missing(self%free_opening, sizes%n_multipliers)
    if (.not. allocated(self%free_response)) allocate (self%free_response(0, 0))
    if (.not. allocated(self%contact_response)) allocate (self%contact_response(0, sizes%n_multipliers))
    call self%field%complete(sizes%n_dofs, sizes%n_multipliers)
    if (.not. allocated(self%free_energy)) allocate (self%free_energy(0, 0))
    call fill_missing(self%shared_energy, sizes%n_multipliers)
    call fill_missing(self%anchors)
    call fill_missing(self%reference_points)
    call fill_missing(self%reference_of_point)
    call fill_missing(self%transforms, sizes%n_multipliers)
  end subroutine complete

  !> Returns the name of an array of this type or of its base type whose shape or values do not fit the model, one of them if there
  !> are several; empty when all fit. A scale that is not positive gives `anchors`. Requires: complete.
  pure function mismatch(self, sizes) result(name)
    class(condensed_data_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = self%shared_mismatch(sizes)
    associate (n => sizes%n_multipliers, n_references => size(self%reference_points))
      if (.not. is_matrix(self%compliance, n, n)) name = 'compliance'
      if (.not. is_matrix(self%free_opening, n, sizes%n_terms)) name = 'free_opening'
      if (.not. (are_indices(self%anchors, n) .and. self%scale > 0)) name = 'anchors'
      if (.not. are_indices(self%reference_points, size(self%start_sets, 2))) name = 'reference_points'
      if (n_references > 0 .and. size(self%reference_of_point) /= size(self%start_sets, 2)) name = 'reference_of_point'
      if (.not. are_indices(self%reference_of_point, n_references)) name = 'reference_of_point'
      if (.not. is_matrix(self%transforms, n, n * n_references)) name = 'transforms'
    end associate
    if (len(name) == 0) name = field_mismatch(self, sizes)
  end function mismatch

  !> Returns the name of an array for displacements whose shape does not fit the model or whose values are not finite; empty when
  !> all fit.
  pure function field_mismatch(self, sizes) result(name)
    class(condensed_data_t), intent(in) :: self
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
    end associate
    if (len(name) == 0) name = self%field%mismatch(sizes%n_dofs, sizes%n_multipliers, size(self%anchors))
  end function field_mismatch

  !> Returns the number of contact rows; anchors count, too.
  pure integer function n_rows(self)
    class(condensed_data_t), intent(in) :: self

    n_rows = size(self%compliance, 1)
  end function n_rows

  !> Returns the compliance [length/force], the largest entry of W, by which W and q are divided before they are transformed. A
  !> transformed problem has forces and openings as unknowns; over a compliance these are forces, too, and what is small beside what
  !> does not depend on the units.
  pure real(rk) function transform_scale(self) result(scale)
    class(condensed_data_t), intent(in) :: self

    scale = max(0.0_rk, maxval(abs(self%compliance)))
    if (.not. scale > 0) scale = 1
  end function transform_scale

  !> Whether modes or compressed responses give the displacement of the dofs that are not exact.
  pure logical function has_modes(self)
    class(condensed_data_t), intent(in) :: self

    has_modes = self%field%is_there()
  end function has_modes

  !> Computes q (the argument opening) = self%free_opening theta. At an anchor, q is `scale` times the work of the loads on the free
  !> motion of this anchor. It becomes exactly zero there if |q| is at most 1e-12 of the sum of the absolute values of its terms.
  subroutine open_freely(self, theta, opening)
    class(condensed_data_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    integer :: i

    call multiply(1.0_rk, self%free_opening, theta, 0.0_rk, opening)
    do i = 1, size(self%anchors)
      associate (row => self%anchors(i))
        if (abs(opening(row)) <= rounding * sum(abs(self%free_opening(row, :) * theta))) opening(row) = 0
      end associate
    end do
  end subroutine open_freely

  !> Returns the size |u|_K [sqrt(force*length)] of the displacement u = G theta - H z in the norm of the stiffness; rigid motions
  !> do not count:
  !>
  !>     |u|_K^2 = theta' G'K G theta - 2 z' H'K G theta + z'C z
  pure real(rk) function size_of_field(self, theta, unknowns, energy) result(size_of)
    class(condensed_data_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] z, shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    !> [force*length] z'C z without the anchors
    real(rk), intent(in) :: energy
    real(rk) :: square
    integer :: i

    square = energy
    do i = 1, size(self%free_energy, 2)
      if (abs(theta(i)) > 0) square = square + theta(i) * (sum(self%free_energy(:, i) * theta(:size(self%free_energy, 1))) - &
        2 * sum(self%shared_energy(:, i) * unknowns))
    end do
    size_of = sqrt(max(0.0_rk, square))
  end function size_of_field

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(condensed_data_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call self%write_shared(file, group)
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
    call file%write(group // '/anchors', self%anchors, description='contacts that hold bodies which nothing else holds, 1-based')
    call file%write(group // '/scale', self%scale, length // '/(' // force // ')', &
      'the unknown of an anchor is its opening over this scale, not its force; its row gives force times scale, not its opening')
    call file%write(group // '/largest_size', self%largest_size, 'sqrt(' // force // '*' // length // ')', &
      'largest size of the contact forces in training, in the norm of the compliance')
    call file%write(group // '/largest_field', self%largest_field, 'sqrt(' // force // '*' // length // ')', &
      'largest size of the displacement in training, in the norm of the stiffness')
    call file%write(group // '/reference_points', self%reference_points, description= &
      'training points whose active sets have a pivot transform, 1-based')
    call file%write(group // '/reference_of_point', self%reference_of_point, description= &
      'of each training point: the reference (1-based) whose active set is nearest to its own')
    call file%write(group // '/transforms', self%transforms, description= &
      'principal pivot transforms of compliance over its largest entry, transposed, one below another')
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(condensed_data_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call self%read_shared(file, group, error)
    call file%read(group // '/compliance', self%compliance, error)
    call file%read(group // '/free_opening', self%free_opening, error)
    call file%read(group // '/free_response', self%free_response, error)
    call file%read(group // '/contact_response', self%contact_response, error)
    call self%field%read(file, group // '/field', error)
    call file%read(group // '/free_energy', self%free_energy, error)
    call file%read(group // '/shared_energy', self%shared_energy, error)
    call file%read(group // '/anchors', self%anchors, error)
    call file%read(group // '/scale', self%scale, error)
    call file%read(group // '/largest_size', self%largest_size, error)
    call file%read(group // '/largest_field', self%largest_field, error)
    call file%read(group // '/reference_points', self%reference_points, error)
    call file%read(group // '/reference_of_point', self%reference_of_point, error)
    call file%read(group // '/transforms', self%transforms, error)
  end subroutine read
end module sig_condensed_data
