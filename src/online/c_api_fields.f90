! SPDX-License-Identifier: BSD-3-Clause
!> The functions of include/signorom.h for fields and their mesh; each one is explained there.
module sig_c_api_fields
  use, intrinsic :: iso_c_binding, only: c_int, c_null_ptr, c_ptr
  use sig_c_handles, only: answered_context, code_ok, context_handle_t, keep, model_handle_t, no_answer, &
    put_integers, put_reals, ready_model, text_at
  use sig_field_map, only: tensors_of
  use sig_kinds, only: rk
  implicit none(type, external)
  private

contains

  integer(c_int) function signorom_get_field_sizes(model, n_cells, n_cell_nodes, n_regions, n_facets, n_facet_nodes) &
    result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: n_cells, n_cell_nodes, n_regions, n_facets, n_facet_nodes
    type(model_handle_t), pointer :: handle
    integer :: sizes(5)

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    sizes = 0
    associate (map => handle%online%model%fields)
      if (map%is_there()) sizes = [map%n_cells(), size(map%of_cells%nodes), size(map%region_names), size(map%facet_entries), &
        size(map%facet_nodes)]
    end associate
    call put_integers(sizes(1:1), n_cells)
    call put_integers(sizes(2:2), n_cell_nodes)
    call put_integers(sizes(3:3), n_regions)
    call put_integers(sizes(4:4), n_facets)
    call put_integers(sizes(5:5), n_facet_nodes)
  end function signorom_get_field_sizes

  integer(c_int) function signorom_get_cells(model, starts, nodes, regions) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: starts, nodes, regions
    type(model_handle_t), pointer :: handle

    handle => model_with_mesh(model, code)
    if (.not. associated(handle)) return
    associate (map => handle%online%model%fields)
      call put_integers(map%of_cells%starts, starts)
      call put_integers(map%of_cells%nodes - 1, nodes)
      call put_integers(map%regions - 1, regions)
    end associate
  end function signorom_get_cells

  integer(c_int) function signorom_get_contact_facets(model, starts, nodes, contacts) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: starts, nodes, contacts
    type(model_handle_t), pointer :: handle

    handle => model_with_mesh(model, code)
    if (.not. associated(handle)) return
    associate (map => handle%online%model%fields)
      call put_integers(map%facet_starts, starts)
      call put_integers(map%facet_nodes - 1, nodes)
      call put_integers(map%facet_entries - 1, contacts)
    end associate
  end function signorom_get_contact_facets

  !> Returns the handle of a model that keeps its mesh. Otherwise it returns null: code = bad_argument if `model` is null or was not
  !> opened successfully, no_answer if the model keeps no mesh.
  function model_with_mesh(model, code) result(handle)
    type(c_ptr), intent(in) :: model
    !> code_ok unless the result is null
    integer(c_int), intent(out) :: code
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    if (handle%online%model%fields%is_there()) return
    code = no_answer
    handle => null()
  end function model_with_mesh

  type(c_ptr) function signorom_region_name(model, region) result(name) bind(c)
    type(c_ptr), value :: model
    integer(c_int), value :: region
    type(model_handle_t), pointer :: handle

    name = c_null_ptr
    handle => ready_model(model)
    if (associated(handle)) name = text_at(handle%region_names, region)
  end function signorom_region_name

  integer(c_int) function signorom_get_stresses(context, stress, von_mises, nodal_stress, nodal_von_mises) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: stress, von_mises, nodal_stress, nodal_von_mises
    type(context_handle_t), pointer :: handle

    handle => context_with_fields(context, code)
    if (.not. associated(handle)) return
    associate (values => handle%fields%values)
      call put_reals(reshape(values%stress, [size(values%stress)]), stress)
      call put_reals(values%von_mises, von_mises)
      call put_reals(reshape(values%stress_smoothed, [size(values%stress_smoothed)]), nodal_stress)
      call put_reals(values%von_mises_smoothed, nodal_von_mises)
    end associate
  end function signorom_get_stresses

  integer(c_int) function signorom_get_imposed_strains(context, strain) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: strain
    type(context_handle_t), pointer :: handle

    handle => context_with_fields(context, code)
    if (.not. associated(handle)) return
    associate (values => handle%fields%values)
      call put_reals(reshape(values%imposed_strain, [size(values%imposed_strain)]), strain)
    end associate
  end function signorom_get_imposed_strains

  integer(c_int) function signorom_get_contact_fields(context, force, pressure, gap, status, cell_status) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: force, pressure, gap, status, cell_status
    type(context_handle_t), pointer :: handle

    handle => context_with_fields(context, code)
    if (.not. associated(handle)) return
    associate (values => handle%fields%values)
      call put_reals(reshape(values%contact_force, [size(values%contact_force)]), force)
      call put_reals(values%contact_pressure, pressure)
      call put_reals(values%gap, gap)
      call put_integers(values%node_contact, status)
      call put_integers(values%cell_contact, cell_status)
    end associate
  end function signorom_get_contact_fields

  integer(c_int) function signorom_get_friction_fields(context, traction, slip, status) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: traction, slip, status
    type(context_handle_t), pointer :: handle

    handle => context_with_fields(context, code)
    if (.not. associated(handle)) return
    associate (values => handle%fields%values)
      if (.not. allocated(values%slips)) then
        code = no_answer
        call keep(handle%message, 'the model has no friction')
        return
      end if
      call put_reals(reshape(values%tangential_traction, [size(values%tangential_traction)]), traction)
      call put_reals(reshape(values%slip, [size(values%slip)]), slip)
      call put_integers(values%node_friction, status)
    end associate
  end function signorom_get_friction_fields

  integer(c_int) function signorom_get_plastic_strains(context, strain, tensor, nodal_strain) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: strain, tensor, nodal_strain
    type(context_handle_t), pointer :: handle

    handle => context_with_fields(context, code)
    if (.not. associated(handle)) return
    associate (values => handle%fields%values)
      call put_strains(handle, values%plastic, values%plastic_smoothed, 'no material of the model has plasticity', strain, &
        tensor, nodal_strain, code)
    end associate
  end function signorom_get_plastic_strains

  integer(c_int) function signorom_get_creep_strains(context, strain, tensor, nodal_strain) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: strain, tensor, nodal_strain
    type(context_handle_t), pointer :: handle

    handle => context_with_fields(context, code)
    if (.not. associated(handle)) return
    associate (values => handle%fields%values)
      call put_strains(handle, values%creep, values%creep_smoothed, 'no material of the model creeps', strain, tensor, &
        nodal_strain, code)
    end associate
  end function signorom_get_creep_strains

  !> Gives plastic strains or creep strains to the caller. If the model has none, code is no_answer, and `refusal` becomes the
  !> message of the context.
  subroutine put_strains(handle, of_cells, of_nodes, refusal, strain, tensor, nodal_strain, code)
    type(context_handle_t), intent(inout) :: handle
    !> as in field_values_t, not allocated: none
    real(rk), allocatable, intent(in) :: of_cells(:, :)
    real(rk), allocatable, intent(in) :: of_nodes(:, :)
    character(*), intent(in) :: refusal
    type(c_ptr), intent(in) :: strain, tensor, nodal_strain
    integer(c_int), intent(out) :: code

    code = no_answer
    if (.not. allocated(of_cells)) then
      call keep(handle%message, refusal)
      return
    end if
    call put_reals(of_cells(7, :), strain)
    call put_reals(reshape(tensors_of(of_cells), [6 * size(of_cells, 2)]), tensor)
    call put_reals(of_nodes(7, :), nodal_strain)
    code = code_ok
  end subroutine put_strains

  !> Returns the handle of a context whose last answer has its fields; the first call after a query computes them. Otherwise it
  !> returns null, and the message of the context (unless `context` is null) says why: code = bad_argument without an answer,
  !> no_answer if the model or the point gives no fields.
  function context_with_fields(context, code) result(handle)
    type(c_ptr), intent(in) :: context
    !> code_ok unless the result is null
    integer(c_int), intent(out) :: code
    type(context_handle_t), pointer :: handle

    ! answered_context needs an array that is not null; the arrays of these functions may be null
    handle => answered_context(context, context, code)
    if (.not. associated(handle)) return
    code = no_answer
    if (len(handle%model%field_refusal) > 0) then
      call keep(handle%message, handle%model%field_refusal)
      handle => null()
      return
    end if
    if (.not. handle%has_fields) then
      call handle%fields%evaluate(handle%model%online, handle%point, handle%answer, handle%has_fields)
      if (.not. handle%has_fields) then
        call keep(handle%message, 'an elastic constant or an imposed strain has no finite value at this point, or Hooke''s ' // &
          'matrix of a material is not finite')
        handle => null()
        return
      end if
    end if
    code = code_ok
  end function context_with_fields
end module sig_c_api_fields
