! SPDX-License-Identifier: BSD-3-Clause
!> Reads and writes the terms of a model in model.h5: <group>/names, and a group per source below <group>/sources.
module sig_term_file
  use sig_errors, only: error_t, make_error
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_term_set, only: start_terms, term_set_t, term_source_t
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: read_terms, write_terms

contains

  !> Writes a term set into a group of an open file, without the names of the parameters and the lines of the deck. A failure of the
  !> file is reported when the file is closed.
  subroutine write_terms(file, group, terms, length)
    type(h5_writer_t), intent(inout) :: file
    !> path of the group in the file
    character(*), intent(in) :: group
    type(term_set_t), intent(in) :: terms
    !> name of the unit of lengths
    character(*), intent(in) :: length
    integer :: i

    call file%write(group // '/names', terms%names, description='what each term is; the values of the terms are theta')
    call file%write(group // '/coordinate_names', terms%coordinate_names)
    call file%write(group // '@is_round', merge(1, 0, terms%is_round))
    call file%write(group // '@n_sources', size(terms%sources))
    do i = 1, size(terms%sources)
      call write_source(file, group // '/sources/' // to_text(i), terms%sources(i), length)
    end do
  end subroutine write_terms

  subroutine write_source(file, group, source, length)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(term_source_t), intent(in) :: source
    character(*), intent(in) :: length

    call file%write(group // '/text', source%text, description='expression of the parameters and the coordinates')
    call file%write(group // '/terms', source%terms, description='term (1-based) of each place, or the only term')
    call file%write(group // '/places', source%places, length, 'coordinates of the places, a place per row')
    call file%write(group // '/minimum', source%minimum, description='lower bound of the window, empty = none')
    call file%write(group // '/maximum', source%maximum, description='upper bound of the window, empty = none')
    call file%write(group // '/facets', source%facets, description='places of each facet, 1-based, filled up with 0')
    call file%write(group // '/orientations', source%orientations, &
      description='of each facet: +1 if the order of its nodes gives the outward normal, else -1')
    call file%write(group // '/dof_terms', source%dof_terms, description='terms of the nodal forces, 0 = none, a place per row')
    call file%write(group // '@kind', source%kind)
    call file%write(group // '@component', source%component)
    call file%write(group // '@axis', source%axis)
    call file%write(group // '@is_cut', merge(1, 0, source%is_cut))
  end subroutine write_source

  !> Reads a term set. Indices in it are not checked here (are_sound_terms). If `error` is allocated before, nothing is read.
  !>
  !> Errors: a dataset or an attribute is missing, or has another type or rank; the number of sources is not the one that the file
  !> says.
  subroutine read_terms(file, group, path, parameter_names, terms, error)
    type(h5_reader_t), intent(in) :: file
    !> path of the group in the file
    character(*), intent(in) :: group
    !> path of the file, for messages
    character(*), intent(in) :: path
    !> names of the model's parameters, which are not in the group
    type(string_t), intent(in) :: parameter_names(:)
    type(term_set_t), intent(out) :: terms
    type(error_t), allocatable, intent(inout) :: error
    type(string_t), allocatable :: coordinate_names(:), names(:)
    integer :: i, is_round, n_sources

    call file%read(group // '/names', names, error)
    call file%read(group // '/coordinate_names', coordinate_names, error)
    call file%read(group // '@is_round', is_round, error)
    call file%read(group // '@n_sources', n_sources, error)
    call start_terms(parameter_names, coordinate_names, is_round == 1, terms)
    if (allocated(error)) return
    terms%names = names
    deallocate (terms%sources)
    allocate (terms%sources(file%count_groups(group // '/sources', n_sources)))
    do i = 1, size(terms%sources)
      call read_source(file, group // '/sources/' // to_text(i), terms%sources(i), error)
    end do
    if (size(terms%sources) /= n_sources .and. .not. allocated(error)) call make_error(error, &
      'the model says that its terms have ' // to_text(n_sources) // ' sources; the file holds ' // &
      to_text(size(terms%sources)), file=path)
  end subroutine read_terms

  subroutine read_source(file, group, source, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(term_source_t), intent(out) :: source
    type(error_t), allocatable, intent(inout) :: error
    integer :: is_cut

    call file%read(group // '/text', source%text, error)
    call file%read(group // '/terms', source%terms, error)
    call file%read(group // '/places', source%places, error)
    call file%read(group // '/minimum', source%minimum, error)
    call file%read(group // '/maximum', source%maximum, error)
    call file%read(group // '/facets', source%facets, error)
    call file%read(group // '/orientations', source%orientations, error)
    call file%read(group // '/dof_terms', source%dof_terms, error)
    call file%read(group // '@kind', source%kind, error)
    call file%read(group // '@component', source%component, error)
    call file%read(group // '@axis', source%axis, error)
    call file%read(group // '@is_cut', is_cut, error)
    source%is_cut = is_cut == 1
  end subroutine read_source
end module sig_term_file
