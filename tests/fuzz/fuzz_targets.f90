! SPDX-License-Identifier: BSD-3-Clause
!> One reader per kind of file. What is accepted is used as the program would use it, so that faults show that reading alone hides.
module fuzz_targets
  use fuzz_seeds, only: n_dofs, n_multipliers, n_parameters, provenance
  use sig_deck_config, only: deck_config_t, imposed_strain_config_t
  use sig_deck_echo, only: echo_deck
  use sig_deck_read, only: read_deck
  use sig_errors, only: error_list_t, error_report, error_t
  use sig_expression, only: expression_t
  use sig_file_seal, only: check_seal, seal_file
  use sig_file_system, only: read_text_file
  use sig_field_query, only: field_query_t, why_no_fields
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_read, only: read_mesh
  use sig_model_file, only: read_model
  use sig_nodal_field, only: nodal_field_t, read_nodal_field
  use sig_rooms, only: rooms_t
  use sig_online_model, only: online_model_t
  use sig_point_list, only: read_points
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_selection, only: read_selection, selection_t
  use sig_snapshot_shard, only: read_shard, shard_content_t, shard_writer_t, snapshot_record_t
  use sig_snapshot_store, only: read_snapshot_set, snapshot_set_t
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: read_input

contains

  !> Reads a file of this kind.
  subroutine read_input(kind, path, sentence)
    !> deck, mesh, field, expression, points, selection, shard, snapshots or model
    character(*), intent(in) :: kind
    character(*), intent(in) :: path
    !> why it was refused; empty where it was accepted
    character(:), allocatable, intent(out) :: sentence
    type(error_t), allocatable :: error

    sentence = ''
    select case (kind)
    case ('deck')
      call try_deck(path, error, sentence)
    case ('mesh')
      call try_mesh(path, error)
    case ('field')
      call try_field(path, error)
    case ('expression')
      call try_expression(path, error, sentence)
    case ('points')
      call try_points(path, error)
    case ('selection')
      call try_selection(path, error)
    case ('shard')
      call try_shard(path, error)
    case ('snapshots')
      call try_snapshots(path, error)
    case ('model')
      call try_model(path, error, sentence)
    case default
      error stop 'unknown kind of file'
    end select
    if (allocated(error)) sentence = error_report(error)
  end subroutine read_input

  !> A deck that is accepted must be accepted again from its own echo.
  subroutine try_deck(path, error, sentence)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable, intent(inout) :: sentence
    type(deck_config_t) :: config, again
    type(error_list_t) :: errors
    character(:), allocatable :: text
    integer :: i

    call read_text_file(path, text, error)
    if (allocated(error)) return
    call read_deck(path, text, config, errors)
    do i = 1, errors%n_errors()
      sentence = error_report(errors%errors(i), text)
    end do
    if (errors%n_errors() > 0) return
    text = echo_deck(config)
    call read_deck(path, text, again, errors)
    if (errors%n_errors() == 0) return
    print '(a)', text, error_report(errors%errors(1), text)
    error stop 'the echo of an accepted deck is refused'
  end subroutine try_deck

  !> As a mesh of the plane and of space.
  subroutine try_mesh(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(mesh_t) :: mesh
    integer :: n_dim

    do n_dim = 2, 3
      call read_mesh(path, n_dim, 1.0e-3_rk, mesh, error)
      if (.not. allocated(error)) exit
    end do
  end subroutine try_mesh

  !> As the temperature of a triangle.
  subroutine try_field(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(imposed_strain_config_t) :: strain
    type(mesh_t) :: mesh
    type(nodal_field_t) :: field

    mesh%n_dim = 2
    mesh%n_nodes = 3
    mesh%node_tags = [1, 2, 3]
    mesh%coordinates = reshape([0.0_rk, 0.0_rk, 1.0_rk, 0.0_rk, 0.0_rk, 1.0_rk], [2, 3])
    allocate (mesh%groups(1))
    mesh%groups(1)%name = 'body'
    mesh%groups(1)%n_dim = 2
    mesh%groups(1)%nodes = [1, 2, 3]
    strain%region%text = 'body'
    strain%field%file = path
    strain%field%path = path
    strain%field%name%text = 'heat'
    call read_nodal_field(mesh, strain, 'deck.yaml', field, error)
  end subroutine try_field

  subroutine try_expression(path, error, sentence)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable, intent(inout) :: sentence
    type(expression_t) :: expression
    type(string_t) :: names(3)
    character(:), allocatable :: text, message
    real(rk) :: value
    logical :: is_valid
    integer :: i

    call read_text_file(path, text, error)
    if (allocated(error)) return
    names(1)%text = 'a'
    names(2)%text = 'squeeze'
    names(3)%text = 'x'
    call expression%create(text, names, message)
    if (allocated(message)) sentence = message
    if (allocated(message)) return
    do i = -1, 1
      call expression%evaluate([1.0e200_rk, 0.5_rk, 3.0_rk] * i, value, is_valid)
      is_valid = expression%uses(names(i + 2)%text)
    end do
    call expression%destroy()
  end subroutine try_expression

  !> Without a box and, where that went well, with one.
  subroutine try_points(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(string_t) :: names(2)
    real(rk), allocatable :: points(:, :)

    names(1)%text = 'squeeze'
    names(2)%text = 'slide'
    call read_points(path, names, points, error)
    if (.not. allocated(error)) call read_points(path, names, points, error, reshape([0.0_rk, 1.0_rk, -1.0_rk, 1.0_rk], [2, 2]))
  end subroutine try_points

  subroutine try_selection(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(selection_t) :: selection

    call read_selection(path, provenance, 'greedy', 2, selection, error)
  end subroutine try_selection

  !> Read, then opened for appending, which cuts a damaged end, then read again: what was good is still there, nothing is lost.
  subroutine try_shard(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(shard_writer_t) :: writer
    type(snapshot_record_t), allocatable :: records(:), again(:)
    integer :: n_dropped

    call read_shard(path, shard_content_t(provenance, n_parameters, n_dofs, n_multipliers), records, n_dropped, error)
    if (allocated(error)) return
    call writer%create(path, shard_content_t(provenance, n_parameters, n_dofs, n_multipliers), error)
    if (.not. allocated(error)) call writer%close(error)
    if (allocated(error)) return
    call read_shard(path, shard_content_t(provenance, n_parameters, n_dofs, n_multipliers), again, n_dropped, error)
    if (allocated(error)) return
    if (n_dropped /= 0 .or. size(again) /= size(records)) error stop 'a shard that was cut at its good end is not whole'
  end subroutine try_shard

  !> A file that has a seal gets one that fits its content, as somebody who means harm would do.
  subroutine try_snapshots(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(snapshot_set_t) :: set
    logical :: is_sealed

    call check_seal(path, is_sealed, error)
    if (is_sealed .or. allocated(error)) call seal_file(path, error)
    if (.not. allocated(error)) call read_snapshot_set(path, '', set, error)
  end subroutine try_snapshots

  !> With a seal that fits, too.
  subroutine try_model(path, error, sentence)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable, intent(inout) :: sentence
    type(online_model_t) :: online
    type(query_t) :: query
    character(:), allocatable :: message

    call seal_file(path, error)
    if (.not. allocated(error)) call read_model(path, online%model, error)
    if (allocated(error)) return
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) then
      sentence = message
    else
      call ask(online, query)
    end if
    call query%destroy()
  end subroutine try_model

  !> At the middle and far outside of the box.
  subroutine ask(online, query)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    type(field_query_t) :: fields
    real(rk), allocatable :: displacement(:), multipliers(:), point(:)
    character(:), allocatable :: message
    logical :: is_valid
    integer :: i

    allocate (multipliers(online%model%n_multipliers))
    message = why_no_fields(online%model)
    if (message == '') call fields%create(online, message)
    do i = 1, 3
      point = sum(online%model%box, 1) / 2 * 10.0_rk**(i - 1)
      call query%evaluate(online, point, answer)
      if (answer%reason <= 0) cycle
      call reconstruct_displacement(online%model, answer, displacement)
      call reconstruct_multipliers(online, answer, rooms, multipliers)
      if (.not. allocated(message)) call fields%evaluate(online, point, answer, is_valid)
    end do
    call fields%destroy()
  end subroutine ask
end module fuzz_targets
