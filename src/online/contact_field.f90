! SPDX-License-Identifier: BSD-3-Clause
!> The displacements H z of all dofs that contact forces cause, with a bound of their error in the norm of the stiffness K.
!>
!> H = K^-1 B' has too many numbers for large parts. So it is kept by modes or in compressed form. Motions of anchors, which are
!> rigid motions, are exact in both. Let z be the unknowns and C = B H, so that |H z|_K^2 = z'C z without the anchors.
!>
!> By modes: H z is nearly Phi a with a = A z, where Phi = H S are orthonormal in the norm of K and A = S'C. This is the projection
!> of H z, so that the error is known: |H z - Phi a|_K^2 = z'C z - |a|^2.
!>
!> Compressed: some modes take the soft motions out of H, which are large in all of its columns, and the rest H - Phi A is kept in
!> blocks of single precision (sig_compressed_matrix). With the errors E of its columns the error is known, too: |E z|_K^2 = z'(E'K
!> E) z, and training computes E'K E.
module sig_contact_field
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_compressed_matrix, only: compressed_matrix_t
  use sig_description_line, only: modes_text
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk, sk
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_shape_checks, only: is_matrix
  use sig_text, only: short_number
  implicit none(type, external)
  private
  public :: contact_field_t

  type :: contact_field_t
    !> [length/force] columns of H that belong to anchors, shape (n_dofs, n_anchors)
    real(rk), allocatable :: motions(:, :)
    !> [length/sqrt(force*length)] Phi, shape (n_dofs, n_modes)
    real(rk), allocatable :: modes(:, :)
    !> [sqrt(force*length)/force] A, shape (n_modes, n_multipliers); zero in the columns of anchors
    real(rk), allocatable :: coordinates(:, :)
    !> [length/force] H - Phi A, shape (n_dofs, n_multipliers); without the columns of anchors, which have no blocks
    type(compressed_matrix_t) :: responses
    !> [length/force] E'K E, its lower triangle column by column with zeros at anchors, shape (n_multipliers * (n_multipliers + 1) /
    !> 2); without compressed responses of size 0
    real(sk), allocatable :: errors(:)
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: is_there
    procedure :: subtract_from
    procedure :: dof_value
    procedure :: motion_of_dof
    procedure :: error_of
    procedure :: describe
    procedure :: write
    procedure :: read
  end type contact_field_t

contains

  !> Allocates with size 0 each array that is not allocated.
  pure subroutine complete(self, n_dofs, n_multipliers)
    class(contact_field_t), intent(inout) :: self
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers

    call fill_missing(self%motions, n_dofs)
    call fill_missing(self%modes, n_dofs)
    if (.not. allocated(self%coordinates)) allocate (self%coordinates(0, n_multipliers))
    call self%responses%complete()
    if (.not. allocated(self%errors)) allocate (self%errors(0))
  end subroutine complete

  !> Returns the name of an array whose shape or values do not fit; empty when all fit. Requires: complete.
  pure function mismatch(self, n_dofs, n_multipliers, n_anchors) result(name)
    class(contact_field_t), intent(in) :: self
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers
    integer, intent(in) :: n_anchors
    character(:), allocatable :: name

    name = ''
    if (.not. is_matrix(self%motions, n_dofs, merge(n_anchors, 0, self%is_there()))) name = 'motions'
    if (.not. is_matrix(self%modes, n_dofs, size(self%coordinates, 1))) name = 'modes'
    if (.not. is_matrix(self%coordinates, size(self%modes, 2), n_multipliers)) name = 'coordinates'
    if (.not. self%responses%fits(n_dofs, n_multipliers)) name = 'responses'
    if (size(self%errors) /= merge(0, n_multipliers * (n_multipliers + 1) / 2, self%responses%is_empty()) .or. &
        .not. all(ieee_is_finite(self%errors))) name = 'errors'
  end function mismatch

  !> Whether there are modes or compressed responses. Requires: complete.
  pure logical function is_there(self)
    class(contact_field_t), intent(in) :: self

    is_there = size(self%modes, 2) > 0 .or. .not. self%responses%is_empty()
  end function is_there

  !> Computes displacement = displacement - H z.
  subroutine subtract_from(self, anchors, unknowns, displacement)
    class(contact_field_t), intent(in) :: self
    !> rows that are anchors, 1-based
    integer, intent(in) :: anchors(:)
    !> [force] z, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: place(size(self%modes, 2))

    call multiply(-1.0_rk, self%motions, unknowns(anchors), 1.0_rk, displacement)
    call multiply(1.0_rk, self%coordinates, unknowns, 0.0_rk, place)
    call multiply(-1.0_rk, self%modes, place, 1.0_rk, displacement)
    if (.not. self%responses%is_empty()) call self%responses%add_product(-1.0_rk, unknowns, displacement)
  end subroutine subtract_from

  !> Returns H z [length] of one dof, 1-based.
  pure real(rk) function dof_value(self, anchors, unknowns, dof) result(value)
    class(contact_field_t), intent(in) :: self
    integer, intent(in) :: anchors(:)
    real(rk), intent(in) :: unknowns(:)
    integer, intent(in) :: dof
    integer :: i

    value = dot_product(self%motions(dof, :), unknowns(anchors))
    if (.not. self%responses%is_empty()) value = value + self%responses%row_product(dof, unknowns)
    do i = 1, size(self%modes, 2)
      value = value + self%modes(dof, i) * dot_product(self%coordinates(i, :), unknowns)
    end do
  end function dof_value

  !> Returns the columns of H of the anchors at one dof, 1-based; shape (n_anchors).
  pure function motion_of_dof(self, dof) result(motion)
    class(contact_field_t), intent(in) :: self
    integer, intent(in) :: dof
    real(rk) :: motion(size(self%motions, 2))

    motion = self%motions(dof, :)
  end function motion_of_dof

  !> Returns the error [sqrt(force*length)] of H z in the norm of K; 0 if there are neither modes nor responses. It is at least 1e-8
  !> of the size of H z: below this it would be lost in rounding.
  pure real(rk) function error_of(self, unknowns, energy) result(error)
    class(contact_field_t), intent(in) :: self
    !> [force] z, shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    !> [force*length] z'C z without the anchors
    real(rk), intent(in) :: energy
    real(rk) :: place(size(self%modes, 2))
    integer :: i

    error = 0
    if (.not. self%is_there()) return
    if (self%responses%is_empty()) then
      place = 0
      do i = 1, size(unknowns)
        if (abs(unknowns(i)) > 0) place = place + self%coordinates(:, i) * unknowns(i)
      end do
      error = energy - sum(place**2)
    else
      error = energy_of_error(self%errors, unknowns)
    end if
    error = sqrt(max(error, epsilon(energy) * energy, 0.0_rk))
  end function error_of

  !> Returns z'(E'K E) z [force*length].
  pure real(rk) function energy_of_error(triangle, unknowns) result(energy)
    !> lower triangle of E'K E
    real(sk), contiguous, intent(in) :: triangle(:)
    !> z
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk) :: values(size(unknowns)), beside
    integer :: at(size(unknowns)), first, i, k, n

    n = 0
    do i = 1, size(unknowns)
      if (.not. abs(unknowns(i)) > 0) cycle
      n = n + 1
      at(n) = i
      values(n) = unknowns(i)
    end do
    energy = 0
    do k = 1, n
      ! place of the column's diagonal, less the row
      first = (at(k) - 1) * size(unknowns) - (at(k) - 1) * at(k) / 2
      beside = 0
      do i = k + 1, n
        beside = beside + triangle(first + at(i)) * values(i)
      end do
      energy = energy + values(k) * (triangle(first + at(k)) * values(k) + 2 * beside)
    end do
  end function energy_of_error

  !> Returns how the displacements are kept, for descriptions; empty if there are neither modes nor responses.
  pure function describe(self) result(text)
    class(contact_field_t), intent(in) :: self
    character(:), allocatable :: text
    real(rk), parameter :: megabyte = 1.0e6_rk

    text = modes_text(size(self%modes, 2))
    if (.not. self%responses%is_empty()) text = 'from compressed responses (' // &
      short_number((self%responses%size_in_bytes() + rk * real(size(self%modes), rk)) / megabyte, 2) // ' MB)'
  end function describe

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(contact_field_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force
    character(:), allocatable :: energy_root

    energy_root = 'sqrt(' // force // '*' // length // ')'
    call file%write(group // '/motions', self%motions, length // '/(' // force // ')', &
      'minus the displacement of all dofs for the unknown 1 of each anchor, an anchor per row')
    call file%write(group // '/modes', self%modes, length // '/' // energy_root, &
      'modes of the displacement under contact forces, orthonormal in the norm of the stiffness; a mode per row')
    call file%write(group // '/coordinates', self%coordinates, energy_root // '/(' // force // ')', &
      'coordinate of each mode in minus the displacement under a unit contact force, a contact per row')
    call file%write(group // '/row_order', self%responses%row_order, description= &
      'dof of each ordered row of the compressed responses, 1-based')
    call file%write(group // '/column_order', self%responses%column_order, description= &
      'contact of each ordered column of the compressed responses, 1-based')
    call file%write(group // '/blocks', self%responses%blocks, description= &
      'first and last ordered row and column (1-based) and rank of each block of the compressed responses, a block per row')
    call file%write(group // '/values', self%responses%values, length // '/(' // force // ')', 'blocks of what the modes ' // &
      'leave, one after the other, column by column: the block if its rank is 0, else its left and right factor')
    call file%write(group // '/errors', self%errors, length // '/(' // force // ')', 'products of the errors of two columns ' // &
      'of the compressed responses in the norm of the stiffness: the lower triangle, column by column')
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(contact_field_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/motions', self%motions, error)
    call file%read(group // '/modes', self%modes, error)
    call file%read(group // '/coordinates', self%coordinates, error)
    call file%read(group // '/row_order', self%responses%row_order, error)
    call file%read(group // '/column_order', self%responses%column_order, error)
    call file%read(group // '/blocks', self%responses%blocks, error)
    call file%read(group // '/values', self%responses%values, error)
    call file%read(group // '/errors', self%errors, error)
  end subroutine read
end module sig_contact_field
