! SPDX-License-Identifier: BSD-3-Clause
!> Writes and reads model.h5. Reading refuses a file that is not a model, has another format, or was changed.
module sig_model_file
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_laws, only: laws_without_friction
  use sig_contact_laws_file, only: read_laws, write_laws
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_field_map_file, only: read_field_map, write_field_map
  use sig_hdf5_format, only: file_format_t, open_sealed, write_format
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_history_file, only: read_history, write_history
  use sig_kinds, only: rk
  use sig_missing_parts, only: fill_missing
  use sig_model, only: complete_model, contact_side_t, model_format_version, model_t, oldest_model_format, &
    validation_statistics_t
  use sig_model_check, only: find_mismatch
  use sig_reduced_kinds, only: create_reduced, kind_names
  use sig_term_file, only: read_terms, write_terms
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: write_model, read_model

  character(*), parameter :: train_hint = 'signorom train DECK writes a model file'
  type(file_format_t), parameter :: model_format = &
    file_format_t('signorom model', oldest_model_format, model_format_version, train_hint)

contains

  !> Writes a model to the file `path`, which appears under its name only when it is complete; an older file is replaced then.
  !>
  !> Arrays that are missing are written with size 0 (complete_model). One rank calls it. Errors: an array of the model does not fit
  !> the others (exit code exit_internal); the file cannot be written.
  subroutine write_model(path, model, error)
    character(*), intent(in) :: path
    type(model_t), intent(in) :: model
    type(error_t), allocatable, intent(out) :: error
    type(h5_writer_t) :: file
    type(model_t) :: whole
    integer :: i

    whole = model
    call complete_model(whole)
    if (find_mismatch(whole) /= '') then
      call make_error(error, 'the data ''' // find_mismatch(whole) // &
        ''' of the model do not fit the rest of it, or are not valid', file=path, &
        exit_code=exit_internal)
      return
    end if
    call file%create(path, error, is_sealed=.true.)
    if (allocated(error)) return
    call write_header(file, whole)
    call write_problem(file, whole)
    do i = 1, size(whole%parts)
      call whole%parts(i)%reduced%write(file, '/' // whole%group_of(i), whole%length_unit, whole%force_unit)
      call file%write('/' // whole%group_of(i) // '@kind', whole%parts(i)%reduced%kind())
    end do
    call whole%choice%write(file)
    call write_validation(file, whole%validation)
    call write_field_map(file, whole%fields, whole%length_unit)
    call file%close(error)
  end subroutine write_model

  subroutine write_header(file, model)
    type(h5_writer_t), intent(inout) :: file
    type(model_t), intent(in) :: model

    ! an earlier reader does not look for friction
    call write_format(file, model_format, merge(oldest_model_format, model_format_version, model%laws%is_plain()), &
      model%code_version)
    call file%write('/@provenance', model%provenance)
    call file%write('/@mesh_hash', model%mesh_hash)
    call file%write('/@n_clusters', model%n_clusters())
    call file%write('/@n_nodes', model%n_nodes)
    call file%write('/@n_dofs', model%n_dofs)
    call file%write('/@n_dim', model%n_dim)
    call file%write('/@n_multipliers', model%n_multipliers)
  end subroutine write_header

  subroutine write_problem(file, model)
    type(h5_writer_t), intent(inout) :: file
    type(model_t), intent(in) :: model
    character(:), allocatable :: length

    length = model%length_unit
    call file%write('/deck', model%deck_text, description='effective deck of the training')
    call file%write('/title', model%title)
    call file%write('/units/length', length)
    call file%write('/units/force', model%force_unit)
    call file%write('/parameters/names', model%parameter_names)
    call file%write('/parameters/units', model%parameter_units)
    call file%write('/parameters/minimum', model%box(1, :), description='lower end of the trained box')
    call file%write('/parameters/maximum', model%box(2, :), description='upper end of the trained box')
    call file%write('/parameters/training_points', model%training_points, description='training points, a point per row')
    call write_history(file, '/history', model%history)
    call write_terms(file, '/terms', model%terms, length)
    call file%write('/mesh/node_tags', model%node_tags, description='tags of the mesh file, a node per entry')
    call file%write('/mesh/coordinates', model%coordinates, length, 'coordinates of the nodes, a node per row')
    call write_side(file, '/contact/first', model%first_side, length)
    call write_side(file, '/contact/second', model%second_side, length)
    call file%write('/contact/areas', model%areas, length, &
      'area of each contact row, in the square of this unit, in plane models in this unit; pressure = contact force / area')
    call model%resultants%write(file, length)
    call write_laws(file, '/contact/laws', model%laws)
    call file%write('/contact/gap', model%gap, length, 'initial gaps, a term per row')
    if (size(model%idle_work%work) > 0) then
      call file%write('/idle_motions/work', model%idle_work%work, description='work of the loads on motions that nothing ' // &
        'holds, a motion per row, a term per column; where the sum of the terms is not zero, there is no equilibrium')
      call file%write('/idle_motions/limits', model%idle_work%limits, description='work up to this size counts as zero')
    end if
    call file%write('/reduction/pod_tolerance', model%pod_tolerance, '1')
    call file%write('/reduction/dirichlet', model%dirichlet)
    call file%write('/certificate/max_error', model%max_error, '1', 'largest allowed relative bound of a cluster''s answer; ' // &
      '0: no limit')
  end subroutine write_problem

  subroutine write_side(file, group, side, length)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(contact_side_t), intent(in) :: side
    character(*), intent(in) :: length

    call file%write(group // '/starts', side%starts, description= &
      'contact i (from 0) has the nodes starts(i) ... starts(i + 1) - 1 of the arrays below; none: a rigid obstacle')
    call file%write(group // '/tags', side%tags, description= &
      'node tags of the mesh file; on the first side the node that carries the contact''s force comes first')
    call file%write(group // '/weights', side%weights, '1', 'share of the contact''s force on the node')
    call file%write(group // '/coordinates', side%coordinates, length, 'coordinates of the nodes, a node per row')
  end subroutine write_side

  subroutine write_validation(file, validation)
    type(h5_writer_t), intent(inout) :: file
    type(validation_statistics_t), intent(in) :: validation

    call file%write('/validation/names', validation%names, description='names of the errors; empty before signorom validate')
    call file%write('/validation/verdict', validation%verdict)
    call file%write('/validation/minimum', validation%minimum)
    call file%write('/validation/median', validation%median)
    call file%write('/validation/p95', validation%p95)
    call file%write('/validation/maximum', validation%maximum)
    call file%write('/validation/method_names', validation%method_names)
    call file%write('/validation/method_counts', validation%method_counts, description='points that each method answered')
  end subroutine write_validation

  !> Reads a model from the file `path`. Errors: there is no such file; it is not HDF5 or not a model, has another format version,
  !> or was cut off or changed; a group of a cluster is missing; a dataset is missing, or has another type or rank; a part has an
  !> unknown kind; arrays do not fit together.
  subroutine read_model(path, model, error)
    character(*), intent(in) :: path
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    type(h5_reader_t) :: file

    call open_sealed(file, path, model_format, model%format_version, error)
    if (allocated(error)) return
    work: block
      call read_header(file, path, model, error)
      if (allocated(error)) exit work
      call read_problem(file, path, model, error)
      if (allocated(error)) exit work
      call read_parts(file, path, model, error)
      if (allocated(error)) exit work
      call model%choice%read(file, path, model%box, error)
      if (allocated(error)) exit work
      call read_validation(file, model%validation, error)
      if (allocated(error)) exit work
      call read_fields(file, path, model, error)
    end block work
    call file%close()
    if (allocated(error)) return
    if (find_mismatch(model) == '') then
      if (model%laws%is_plain()) model%laws = laws_without_friction(model%n_multipliers)
    else
      call make_error(error, 'the data ''' // find_mismatch(model) // &
        ''' of the model do not fit the rest of it, or are not valid', file=path, &
        hint=train_hint)
    end if
  end subroutine read_model

  subroutine read_header(file, path, model, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: path
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(inout) :: error
    integer :: n_clusters, n_found

    call file%read('/@code_version', model%code_version, error)
    call file%read('/@provenance', model%provenance, error)
    call file%read('/@mesh_hash', model%mesh_hash, error)
    call file%read('/@n_clusters', n_clusters, error)
    call file%read('/@n_nodes', model%n_nodes, error)
    call file%read('/@n_dofs', model%n_dofs, error)
    call file%read('/@n_dim', model%n_dim, error)
    call file%read('/@n_multipliers', model%n_multipliers, error)
    model%has_fallback = file%has('/fallback')
    n_found = file%count_groups('/clusters', n_clusters)
    allocate (model%parts(n_found + merge(1, 0, model%has_fallback)))
    if (n_found /= n_clusters .and. .not. allocated(error)) call make_error(error, 'the model says that it has ' // &
      to_text(n_clusters) // ' clusters; the file holds ' // to_text(n_found), file=path, hint=train_hint)
  end subroutine read_header

  subroutine read_problem(file, path, model, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: path
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(inout) :: error

    call file%read('/deck', model%deck_text, error)
    call file%read('/title', model%title, error)
    call file%read('/units/length', model%length_unit, error)
    call file%read('/units/force', model%force_unit, error)
    call read_parameters(file, model, error)
    call read_history(file, '/history', model%history, error)
    call read_terms(file, '/terms', path, model%parameter_names, model%terms, error)
    call file%read('/mesh/node_tags', model%node_tags, error)
    call file%read('/mesh/coordinates', model%coordinates, error)
    call read_side(file, '/contact/first', model%first_side, error)
    call read_side(file, '/contact/second', model%second_side, error)
    call file%read('/contact/areas', model%areas, error)
    call model%resultants%read(file, model%n_dim, error)
    call read_laws(file, '/contact/laws', model%n_multipliers, model%laws, error)
    call file%read('/contact/gap', model%gap, error)
    if (file%has('/idle_motions')) then
      call file%read('/idle_motions/work', model%idle_work%work, error)
      call file%read('/idle_motions/limits', model%idle_work%limits, error)
    end if
    call fill_missing(model%idle_work%work, model%terms%n_terms())
    call fill_missing(model%idle_work%limits, model%terms%n_terms())
    call file%read('/reduction/pod_tolerance', model%pod_tolerance, error)
    call file%read('/reduction/dirichlet', model%dirichlet, error)
    call file%read('/certificate/max_error', model%max_error, error)
  end subroutine read_problem

  !> Reads the data for fields, if the file has some. Gaps, areas and entries of the contact rows are copied from the model. Errors:
  !> those of read_field_map.
  subroutine read_fields(file, path, model, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: path
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(inout) :: error
    type(contact_rows_t) :: rows

    call read_field_map(file, path, model%parameter_names, model%fields, error)
    if (allocated(error) .or. .not. model%fields%is_there()) return
    rows = model%fields%force_rows
    rows%gap = model%gap
    rows%areas = model%areas
    rows%contact_entry = model%resultants%entries
    ! a file whose arrays do not fit is refused later
    associate (sizes => [model%laws%n_contacts, rows%n_rows, size(rows%areas), size(rows%contact_entry), size(rows%gap, 1)])
      call model%fields%set_rows(rows, merge(model%laws%n_contacts, 0, all(sizes >= model%laws%n_contacts)))
    end associate
  end subroutine read_fields

  subroutine read_side(file, group, side, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(contact_side_t), intent(inout) :: side
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/starts', side%starts, error)
    call file%read(group // '/tags', side%tags, error)
    call file%read(group // '/weights', side%weights, error)
    call file%read(group // '/coordinates', side%coordinates, error)
  end subroutine read_side

  subroutine read_parameters(file, model, error)
    type(h5_reader_t), intent(in) :: file
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(inout) :: error
    real(rk), allocatable :: maximum(:), minimum(:)

    call file%read('/parameters/names', model%parameter_names, error)
    call file%read('/parameters/units', model%parameter_units, error)
    call file%read('/parameters/minimum', minimum, error)
    call file%read('/parameters/maximum', maximum, error)
    call file%read('/parameters/training_points', model%training_points, error)
    allocate (model%box(2, min(size(minimum), size(maximum))))
    model%box(1, :) = minimum(:size(model%box, 2))
    model%box(2, :) = maximum(:size(model%box, 2))
  end subroutine read_parameters

  !> Reads the parts, whose number is known from read_header. The file says of which kind each part is. Errors: a kind is unknown,
  !> or a dataset is missing, or has another type or rank.
  subroutine read_parts(file, path, model, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: path
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: group, kind
    integer :: i

    do i = 1, size(model%parts)
      group = '/' // model%group_of(i)
      call file%read(group // '@kind', kind, error)
      if (allocated(error)) return
      call create_reduced(kind, model%parts(i)%reduced)
      if (.not. allocated(model%parts(i)%reduced)) then
        call make_error(error, 'the group ''' // group(2:) // ''' of the model is of the kind ''' // kind // '''; known are: ' // &
          kind_names, file=path, hint=train_hint)
        return
      end if
      call model%parts(i)%reduced%read(file, group, error)
    end do
  end subroutine read_parts

  subroutine read_validation(file, validation, error)
    type(h5_reader_t), intent(in) :: file
    type(validation_statistics_t), intent(inout) :: validation
    type(error_t), allocatable, intent(inout) :: error

    call file%read('/validation/names', validation%names, error)
    call file%read('/validation/verdict', validation%verdict, error)
    call file%read('/validation/minimum', validation%minimum, error)
    call file%read('/validation/median', validation%median, error)
    call file%read('/validation/p95', validation%p95, error)
    call file%read('/validation/maximum', validation%maximum, error)
    call file%read('/validation/method_names', validation%method_names, error)
    call file%read('/validation/method_counts', validation%method_counts, error)
  end subroutine read_validation
end module sig_model_file
