! SPDX-License-Identifier: BSD-3-Clause
!> The functions of include/signorom.h for models; each one is explained there.
module sig_c_api_model
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_null_ptr, c_ptr
  use sig_c_handles, only: bad_argument, bad_model, code_ok, keep, model_handle_t, no_memory, put_integers, put_reals, &
    put_text, ready_model, text_at
  use sig_c_strings, only: from_c
  use sig_errors, only: error_report, error_t
  use sig_field_query, only: why_no_fields
  use sig_contact_laws, only: contact_laws_t
  use sig_model, only: contact_side_t, model_t
  use sig_model_description, only: describe_model
  use sig_model_file, only: read_model
  use sig_reduced, only: displacement_exact
  implicit none(type, external)
  private

  !> the structure signorom_sizes of signorom.h
  type, bind(c) :: c_sizes_t
    integer(c_int) :: n_parameters, n_clusters, n_contacts, n_nodes, n_dimensions, n_dofs, n_training_points
    integer(c_int) :: has_full_order_multipliers, has_full_order_displacement
  end type c_sizes_t

contains

  integer(c_int) function signorom_open(path, model) result(code) bind(c)
    type(c_ptr), value :: path
    type(c_ptr), intent(out), optional :: model
    type(model_handle_t), pointer :: handle
    type(error_t), allocatable :: error
    character(:), allocatable :: message
    integer :: status

    code = bad_argument
    if (.not. present(model)) return
    model = c_null_ptr
    allocate (handle, stat=status)
    code = no_memory
    if (status /= 0) return
    model = c_loc(handle)
    call keep(handle%message, '')
    code = bad_argument
    if (.not. c_associated(path)) then
      call keep(handle%message, 'the path is a null pointer')
      return
    end if
    code = bad_model
    call read_model(from_c(path), handle%online%model, error)
    if (allocated(error)) then
      call keep(handle%message, error_report(error))
      return
    end if
    call handle%online%prepare(message)
    if (allocated(message)) then
      call keep(handle%message, from_c(path) // ': error: the model cannot answer: ' // message)
      return
    end if
    call keep_texts(handle)
    handle%field_refusal = why_no_fields(handle%online%model)
    handle%is_ready = .true.
    code = code_ok
  end function signorom_open

  subroutine keep_texts(handle)
    type(model_handle_t), intent(inout) :: handle
    integer :: i

    associate (model => handle%online%model)
      call keep(handle%texts(1), model%title)
      call keep(handle%texts(2), model%length_unit)
      call keep(handle%texts(3), model%force_unit)
      call keep(handle%texts(4), model%code_version)
      call keep(handle%texts(5), model%deck_text)
      call keep(handle%texts(6), describe_model(model))
      call keep(handle%texts(7), '')
      call keep(handle%texts(8), '')
      call keep(handle%texts(9), model%parts(1)%reduced%kind())
      call keep(handle%texts(10), model%validation%verdict)
      if (model%fields%is_there()) then
        call keep(handle%texts(7), model%fields%stress_unit)
        call keep(handle%texts(8), model%fields%area_unit)
      end if
      allocate (handle%names(size(model%parameter_names)), handle%units(size(model%parameter_names)))
      do i = 1, size(handle%names)
        call keep(handle%names(i), model%parameter_names(i)%text)
        call keep(handle%units(i), model%parameter_units(i)%text)
      end do
      allocate (handle%contact_names(model%resultants%n_entries()))
      do i = 1, size(handle%contact_names)
        call keep(handle%contact_names(i), model%resultants%names(i)%text)
      end do
      i = 0
      if (model%fields%is_there()) i = size(model%fields%region_names)
      allocate (handle%region_names(i))
      do i = 1, size(handle%region_names)
        call keep(handle%region_names(i), model%fields%region_names(i)%text)
      end do
    end associate
  end subroutine keep_texts

  type(c_ptr) function signorom_model_message(model) result(message) bind(c)
    type(c_ptr), value :: model
    type(model_handle_t), pointer :: handle

    message = c_null_ptr
    if (.not. c_associated(model)) return
    call c_f_pointer(model, handle)
    message = c_loc(handle%message%characters)
  end function signorom_model_message

  subroutine signorom_close(model) bind(c)
    type(c_ptr), value :: model
    type(model_handle_t), pointer :: handle

    if (.not. c_associated(model)) return
    call c_f_pointer(model, handle)
    deallocate (handle)
  end subroutine signorom_close

  integer(c_int) function signorom_get_sizes(model, sizes) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: sizes
    type(model_handle_t), pointer :: handle
    type(c_sizes_t), pointer :: target

    code = bad_argument
    handle => ready_model(model)
    if (.not. (associated(handle) .and. c_associated(sizes))) return
    call c_f_pointer(sizes, target)
    associate (whole => handle%online%model)
      target%n_parameters = size(whole%parameter_names)
      target%n_clusters = whole%n_clusters()
      target%n_contacts = whole%n_multipliers
      target%n_nodes = whole%n_nodes
      target%n_dimensions = whole%n_dim
      target%n_dofs = whole%n_dofs
      target%n_training_points = size(whole%training_points, 2)
      target%has_full_order_multipliers = merge(1, 0, whole%has_fallback .or. whole%parts(1)%reduced%is_exact())
      target%has_full_order_displacement = merge(1, 0, has_exact_field(whole))
    end associate
    code = code_ok
  end function signorom_get_sizes

  !> Whether at least one part of the model, a cluster or the fallback, has exact displacements of all nodes.
  pure logical function has_exact_field(model)
    type(model_t), intent(in) :: model
    integer :: i, k

    has_exact_field = .false.
    do i = 1, size(model%parts)
      associate (part => model%parts(i)%reduced)
        has_exact_field = has_exact_field .or. &
          all([(part%displacement_source(k) == displacement_exact, k=1, model%n_dofs)])
      end associate
    end do
  end function has_exact_field

  type(c_ptr) function signorom_text(model, kind) result(text) bind(c)
    type(c_ptr), value :: model
    integer(c_int), value :: kind
    type(model_handle_t), pointer :: handle

    text = c_null_ptr
    handle => ready_model(model)
    if (associated(handle)) text = text_at(handle%texts, kind)
  end function signorom_text

  integer(c_int) function signorom_get_parameter(model, i, name, unit, minimum, maximum) result(code) bind(c)
    type(c_ptr), value :: model
    integer(c_int), value :: i
    type(c_ptr), value :: name, unit, minimum, maximum
    type(model_handle_t), pointer :: handle

    code = bad_argument
    handle => ready_model(model)
    if (.not. associated(handle)) return
    if (i < 0 .or. i >= size(handle%names)) return
    call put_text(handle%names(i + 1), name)
    call put_text(handle%units(i + 1), unit)
    call put_reals(handle%online%model%box(1:1, i + 1), minimum)
    call put_reals(handle%online%model%box(2:2, i + 1), maximum)
    code = code_ok
  end function signorom_get_parameter

  integer(c_int) function signorom_get_contact_nodes(model, side, starts, tags, weights, coordinates) result(code) bind(c)
    type(c_ptr), value :: model
    integer(c_int), value :: side
    type(c_ptr), value :: starts, tags, weights, coordinates
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    select case (side)
    case (0)
      call put_side(handle%online%model%first_side, handle%online%model%laws, starts, tags, weights, coordinates)
    case (1)
      call put_side(handle%online%model%second_side, handle%online%model%laws, starts, tags, weights, coordinates)
    case default
      code = bad_argument
    end select
  end function signorom_get_contact_nodes

  !> Gives the nodes of each contact force; tangential forces have those of their contact.
  subroutine put_side(side, laws, starts, tags, weights, coordinates)
    type(contact_side_t), intent(in) :: side
    type(contact_laws_t), intent(in) :: laws
    type(c_ptr), intent(in) :: starts, tags, weights, coordinates
    integer :: contacts(laws%n_forces()), ends(size(contacts) + 1)
    integer, allocatable :: nodes(:)
    integer :: i, k

    contacts = laws%contacts_of_forces()
    nodes = [([(i, i=side%starts(contacts(k)) + 1, side%starts(contacts(k) + 1))], k=1, size(contacts))]
    ends = 0
    do k = 1, size(contacts)
      ends(k + 1) = ends(k) + side%starts(contacts(k) + 1) - side%starts(contacts(k))
    end do
    call put_integers(ends, starts)
    call put_integers(side%tags(nodes), tags)
    call put_reals(side%weights(nodes), weights)
    call put_reals(reshape(side%coordinates(:, nodes), [size(side%coordinates, 1) * size(nodes)]), coordinates)
  end subroutine put_side

  integer(c_int) function signorom_get_contact_areas(model, areas) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: areas
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (associated(handle)) call put_reals(handle%online%model%areas, areas)
  end function signorom_get_contact_areas

  integer(c_int) function signorom_get_force_directions(model, contacts, directions) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: contacts, directions
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    associate (whole => handle%online%model)
      if (size(whole%resultants%unit_forces, 2) /= whole%n_multipliers) then
        code = bad_argument
        return
      end if
      call put_integers(whole%laws%contacts_of_forces() - 1, contacts)
      call put_reals(reshape(whole%resultants%unit_forces, [size(whole%resultants%unit_forces)]), directions)
    end associate
  end function signorom_get_force_directions

  integer(c_int) function signorom_get_contact_entries(model, n_entries, n_moments, entries) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: n_entries, n_moments, entries
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    associate (resultants => handle%online%model%resultants)
      call put_integers([resultants%n_entries()], n_entries)
      call put_integers([resultants%n_moments()], n_moments)
      call put_integers(resultants%entries - 1, entries)
    end associate
  end function signorom_get_contact_entries

  type(c_ptr) function signorom_contact_entry_name(model, entry) result(name) bind(c)
    type(c_ptr), value :: model
    integer(c_int), value :: entry
    type(model_handle_t), pointer :: handle

    name = c_null_ptr
    handle => ready_model(model)
    if (associated(handle)) name = text_at(handle%contact_names, entry)
  end function signorom_contact_entry_name

  integer(c_int) function signorom_get_resultants(model, multipliers, areas, forces, moments) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: multipliers, areas, forces, moments
    type(model_handle_t), pointer :: handle
    real(c_double), pointer :: given(:), told_areas(:), told_forces(:, :), told_moments(:, :)

    code = bad_argument
    handle => ready_model(model)
    if (.not. associated(handle)) return
    if (.not. all([c_associated(multipliers), c_associated(areas), c_associated(forces), c_associated(moments)])) return
    associate (whole => handle%online%model, n => handle%online%model%resultants%n_entries())
      call c_f_pointer(multipliers, given, [whole%n_multipliers])
      call c_f_pointer(areas, told_areas, [n])
      call c_f_pointer(forces, told_forces, [whole%n_dim, n])
      call c_f_pointer(moments, told_moments, [whole%resultants%n_moments(), n])
      call whole%resultants%evaluate(whole%laws, whole%areas, given, told_areas, told_forces, told_moments)
    end associate
    code = code_ok
  end function signorom_get_resultants

  integer(c_int) function signorom_get_nodes(model, tags, coordinates) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: tags, coordinates
    type(model_handle_t), pointer :: handle

    code = bad_argument
    handle => ready_model(model)
    if (.not. associated(handle)) return
    if (size(handle%online%model%node_tags) /= handle%online%model%n_nodes) return
    call put_integers(handle%online%model%node_tags, tags)
    call put_reals(reshape(handle%online%model%coordinates, [size(handle%online%model%coordinates)]), coordinates)
    code = code_ok
  end function signorom_get_nodes

  integer(c_int) function signorom_get_displacement_sources(model, sources) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: sources
    type(model_handle_t), pointer :: handle
    integer :: i

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    associate (whole => handle%online%model)
      call put_integers([(whole%parts(1)%reduced%displacement_source(whole%n_dim * i), i=1, whole%n_nodes)], sources)
    end associate
  end function signorom_get_displacement_sources

  integer(c_int) function signorom_get_next_cluster(model, point, cluster) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: point, cluster
    type(model_handle_t), pointer :: handle
    real(c_double), pointer :: values(:)

    code = bad_argument
    handle => ready_model(model)
    if (.not. associated(handle)) return
    if (.not. (c_associated(point) .and. c_associated(cluster))) return
    call c_f_pointer(point, values, [size(handle%names)])
    call put_integers([handle%online%model%choice%next_cluster(values) - 1], cluster)
    code = code_ok
  end function signorom_get_next_cluster

  integer(c_int) function signorom_get_domain_contacts(model, cluster, n, contacts) result(code) bind(c)
    type(c_ptr), value :: model
    integer(c_int), value :: cluster
    type(c_ptr), value :: n, contacts
    type(model_handle_t), pointer :: handle

    code = bad_argument
    handle => ready_model(model)
    if (.not. associated(handle)) return
    if (cluster < 0 .or. cluster >= handle%online%model%n_clusters()) return
    associate (rows => handle%online%model%parts(cluster + 1)%reduced%contact_rows())
      call put_integers([size(rows)], n)
      call put_integers(rows - 1, contacts)
    end associate
    code = code_ok
  end function signorom_get_domain_contacts
end module sig_c_api_model
