! SPDX-License-Identifier: BSD-3-Clause
!> The data of a hyper-reduced model whose stiffness depends on the parameters.
!>
!> K is a sum of parts, K = K_0 + sum over q of m_q K_q, where m_q are the bulk and the shear modulus of each material whose elastic
!> constants depend on the parameters. All parts of (10) that come from K are such sums, too. The lifting is one field for all
!> parameters: the modes represent the rest of the displacement, and the forces K(mu) lifting are sums of products of a modulus and
!> a lifted term.
module sig_hhr_stiffness
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_missing_parts, only: fill_missing
  use sig_shape_checks, only: are_indices, is_matrix
  implicit none(type, external)
  private
  public :: hhr_stiffness_t

  !> kind of a modulus: bulk, E / (3 (1 - 2 nu)); shear, E / (2 (1 + nu)); bulk in plane stress, E / (2 (1 - nu))
  integer, parameter, public :: bulk_modulus = 1, shear_modulus = 2, thin_bulk_modulus = 3

  type :: hhr_stiffness_t
    !> kind of each m_q; empty: the stiffness does not depend on the parameters
    integer, allocatable :: kinds(:)
    !> the model's terms E and nu of the material of each m_q, 1-based
    integer, allocatable :: young_terms(:)
    integer, allocatable :: poisson_terms(:)
    !> [force/length**2] moduli in the middle of the parameter box, where the condition number of K_r was measured
    real(rk), allocatable :: reference(:)
    !> [length] V[A]' K_q V per unit of m_q, column by column; shape (n_modes**2, n_moduli)
    real(rk), allocatable :: parts(:, :)
    !> [length**2] - V[A]' K_q lifting, lifted term by lifted term; shape (n_modes * n_lifted_terms, n_moduli)
    real(rk), allocatable :: lifting_parts(:, :)
  contains
    procedure :: is_there
    procedure :: has_material
    procedure :: moduli_at
    procedure :: complete
    procedure :: mismatch
    procedure :: write
    procedure :: read
  end type hhr_stiffness_t

contains

  !> Whether the stiffness depends on the parameters.
  pure logical function is_there(self)
    class(hhr_stiffness_t), intent(in) :: self

    is_there = .false.
    if (allocated(self%kinds)) is_there = size(self%kinds) > 0
  end function is_there

  !> Whether the elastic constants of all m_q are possible at a point: Young's moduli above 0, Poisson's ratios above -1 and below
  !> 0.5.
  pure logical function has_material(self, theta)
    class(hhr_stiffness_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    integer :: i

    has_material = .true.
    do i = 1, size(self%kinds)
      has_material = has_material .and. theta(self%young_terms(i)) > 0 .and. abs(theta(self%poisson_terms(i)) + 0.25_rk) < 0.75_rk
    end do
  end function has_material

  !> Computes the moduli m_q from the values of the model's terms. Requires: has_material.
  pure subroutine moduli_at(self, theta, moduli)
    class(hhr_stiffness_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force/length**2] m_q, shape (n_moduli)
    real(rk), intent(out) :: moduli(:)
    integer :: i

    do i = 1, size(moduli)
      associate (young => theta(self%young_terms(i)), poisson => theta(self%poisson_terms(i)))
        select case (self%kinds(i))
        case (bulk_modulus)
          moduli(i) = young / (3 * (1 - 2 * poisson))
        case (shear_modulus)
          moduli(i) = young / (2 * (1 + poisson))
        case default
          moduli(i) = young / (2 * (1 - poisson))
        end select
      end associate
    end do
  end subroutine moduli_at

  !> Allocates with size 0 each array of this type that is not allocated.
  pure subroutine complete(self)
    class(hhr_stiffness_t), intent(inout) :: self

    call fill_missing(self%kinds)
    call fill_missing(self%young_terms)
    call fill_missing(self%poisson_terms)
    call fill_missing(self%reference)
    call fill_missing(self%parts, 0)
    call fill_missing(self%lifting_parts, 0)
  end subroutine complete

  !> Returns the name (`stiffness/...`) of an array of this type whose shape, indices or values do not fit; empty when all fit, or
  !> when there are no data. Requires: complete or read.
  pure function mismatch(self, n_terms, n_modes, n_lifted) result(name)
    class(hhr_stiffness_t), intent(in) :: self
    !> number of terms of the model
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_modes
    !> number of columns of the lifting
    integer, intent(in) :: n_lifted
    character(:), allocatable :: name

    name = ''
    if (.not. self%is_there()) return
    associate (n => size(self%kinds))
      if (.not. are_indices(self%kinds, thin_bulk_modulus)) name = 'stiffness/kinds'
      if (size(self%young_terms) /= n .or. .not. are_indices(self%young_terms, n_terms)) name = 'stiffness/young_terms'
      if (size(self%poisson_terms) /= n .or. .not. are_indices(self%poisson_terms, n_terms)) name = 'stiffness/poisson_terms'
      if (size(self%reference) /= n) name = 'stiffness/reference'
      if (.not. is_matrix(self%parts, n_modes**2, n)) name = 'stiffness/parts'
      if (.not. is_matrix(self%lifting_parts, n_modes * n_lifted, n)) name = 'stiffness/lifting_parts'
    end associate
  end function mismatch

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(hhr_stiffness_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/kinds', self%kinds, description='kind of each modulus: 1 bulk, 2 shear, 3 bulk in plane stress')
    call file%write(group // '/young_terms', self%young_terms, description='number (1-based) of the term that is Young''s ' // &
      'modulus, for each modulus')
    call file%write(group // '/poisson_terms', self%poisson_terms, description='number (1-based) of the term that is ' // &
      'Poisson''s ratio, for each modulus')
    call file%write(group // '/reference', self%reference, force // '/(' // length // ')^2', &
      'moduli in the middle of the parameter box, for which the condition number of the reduced stiffness was computed')
    call file%write(group // '/parts', self%parts, length, &
      'parts of the reduced stiffness per unit of each modulus, column by column, a modulus per row')
    call file%write(group // '/lifting_parts', self%lifting_parts, '(' // length // ')^2', &
      'forces against the lifting per unit of each modulus, lifted term by lifted term, a modulus per row')
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(hhr_stiffness_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/kinds', self%kinds, error)
    call file%read(group // '/young_terms', self%young_terms, error)
    call file%read(group // '/poisson_terms', self%poisson_terms, error)
    call file%read(group // '/reference', self%reference, error)
    call file%read(group // '/parts', self%parts, error)
    call file%read(group // '/lifting_parts', self%lifting_parts, error)
  end subroutine read
end module sig_hhr_stiffness
