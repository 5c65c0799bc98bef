! SPDX-License-Identifier: BSD-3-Clause
!> Friction and ties of contacts in a model file.
module sig_contact_laws_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_contact_laws, only: contact_laws_t
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_shape_checks, only: are_indices
  implicit none(type, external)
  private
  public :: read_laws, write_laws, laws_fit

contains

  !> Writes the laws to a group; nothing where contacts only open and close. A failure of the file is reported when it is closed.
  subroutine write_laws(file, group, laws)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(contact_laws_t), intent(in) :: laws

    if (laws%is_plain()) return
    call file%write(group // '/tangents', laws%tangents, description='rows (1-based among all contact forces) of the ' // &
      'tangential forces of each contact, a contact per row; 0: none')
    call file%write(group // '/directions', laws%directions, description='which tangent of the contact each of them has')
    call file%write(group // '/is_tied', merge(1, 0, laws%is_tied), description='1: the contact never opens, and never slips ' // &
      'along its tangential forces')
    call file%write(group // '/friction_factors', laws%friction_factors, '1', &
      'coefficient of friction = factor times the value of the term')
    call file%write(group // '/friction_terms', laws%friction_terms, description='term (1-based) of each contact')
  end subroutine write_laws

  !> Reads the laws; without the group, no contact has friction: then n_contacts is set alone, because the number in the file may be
  !> anything. Errors: a dataset is missing, or has another type or rank.
  subroutine read_laws(file, group, n_multipliers, laws, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    !> number of all contact forces of the model
    integer, intent(in) :: n_multipliers
    type(contact_laws_t), intent(out) :: laws
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: ties(:)

    if (.not. file%has(group)) then
      laws%n_contacts = n_multipliers
      return
    end if
    call file%read(group // '/tangents', laws%tangents, error)
    call file%read(group // '/directions', laws%directions, error)
    call file%read(group // '/is_tied', ties, error)
    call file%read(group // '/friction_factors', laws%friction_factors, error)
    call file%read(group // '/friction_terms', laws%friction_terms, error)
    laws%is_tied = ties /= 0
    laws%n_contacts = size(ties)
  end subroutine read_laws

  !> Whether shapes, rows, terms and numbers fit a model: its forces are the normal ones of all contacts, then each tangential one
  !> once. Without arrays all forces must be normal ones.
  pure logical function laws_fit(laws, n_multipliers, n_terms)
    type(contact_laws_t), intent(in) :: laws
    integer, intent(in) :: n_multipliers
    integer, intent(in) :: n_terms
    logical, allocatable :: is_there(:)
    integer :: k

    laws_fit = laws%n_contacts == n_multipliers
    if (.not. allocated(laws%tangents)) return
    associate (n => laws%n_contacts)
      laws_fit = all(shape(laws%tangents) == [2, n]) .and. all(shape(laws%directions) == [2, n]) .and. &
        size(laws%friction_factors) == n .and. &
        size(laws%friction_terms) == n .and. are_indices(laws%friction_terms, n_terms)
      if (laws_fit) laws_fit = all(ieee_is_finite(laws%friction_factors)) .and. laws%n_forces() == n_multipliers .and. &
        all(laws%tangents(2, :) == 0 .or. laws%tangents(1, :) > 0) .and. &
        all(laws%tangents == 0 .or. (laws%tangents > n .and. laws%tangents <= n_multipliers))
      if (.not. laws_fit) return
      allocate (is_there(n_multipliers), source=.false.)
      is_there(:n) = .true.
      do k = 1, n
        is_there(pack(laws%tangents(:, k), laws%tangents(:, k) > 0)) = .true.
      end do
      ! so many rows as there are, and each of them is there
      laws_fit = all(is_there)
    end associate
  end function laws_fit
end module sig_contact_laws_file
