! SPDX-License-Identifier: BSD-3-Clause
!> Answers of a trained Signorom model (model.h5) for programs in Fortran: the functions of signorom.h under their own names.
!>
!> Compile this file with the program and link with -lsignorom_online. signorom.h explains each function and each member.
!>
!>     type(c_ptr) :: model, context
!>     type(signorom_answer) :: answer
!>     integer(c_int) :: code
!>     code = signorom_open('model.h5' // c_null_char, model)
!>     if (code /= SIGNOROM_OK) print *, signorom_string(signorom_model_message(model))
!>     code = signorom_create_context(model, context)
!>     code = signorom_query(context, [170.0_c_double, 3.2_c_double], answer)
!>     if (code /= SIGNOROM_OK) print *, signorom_string(signorom_message(context))
!>     code = signorom_get_multipliers(context, multipliers)
!>     call signorom_free_context(context)
!>     call signorom_close(model)
!>
!> An argument that may be a null pointer in C is optional here. Arrays are stored as in C: point i of `points` is
!> points(:, i). Numbers of nodes, contacts and clusters count from 0. signorom_get_resultants returns SIGNOROM_BAD_ARGUMENT
!> unless all its arrays are given.
module signorom
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, c_null_ptr, c_ptr, c_size_t
  implicit none(type, external)
  private

  ! the values of signorom_code
  integer(c_int), parameter, public :: SIGNOROM_OK = 0, SIGNOROM_NO_ANSWER = 1, SIGNOROM_BAD_ARGUMENT = 2, &
    SIGNOROM_BAD_MODEL = 3, SIGNOROM_NO_MEMORY = 4
  ! the values of signorom_method
  integer(c_int), parameter, public :: SIGNOROM_METHOD_NONE = 0, SIGNOROM_METHOD_ACTIVE_SET = 1, &
    SIGNOROM_METHOD_BLOCK_PIVOTING = 2, SIGNOROM_METHOD_LEMKE = 3, SIGNOROM_METHOD_CONDENSED = 4
  ! the values of signorom_text_kind
  integer(c_int), parameter, public :: SIGNOROM_TEXT_TITLE = 0, SIGNOROM_TEXT_LENGTH_UNIT = 1, SIGNOROM_TEXT_FORCE_UNIT = 2, &
    SIGNOROM_TEXT_CODE_VERSION = 3, SIGNOROM_TEXT_DECK = 4, SIGNOROM_TEXT_DESCRIPTION = 5, SIGNOROM_TEXT_STRESS_UNIT = 6, &
    SIGNOROM_TEXT_AREA_UNIT = 7, SIGNOROM_TEXT_KIND = 8, SIGNOROM_TEXT_VERDICT = 9
  ! the values of signorom_displacement_source
  integer(c_int), parameter, public :: SIGNOROM_DISPLACEMENT_NONE = 0, SIGNOROM_DISPLACEMENT_BY_MODES = 1, &
    SIGNOROM_DISPLACEMENT_EXACT = 2
  real(c_double), parameter, public :: SIGNOROM_NO_BOUND = -1.0_c_double

  type, bind(c), public :: signorom_sizes
    integer(c_int) :: n_parameters, n_clusters, n_contacts, n_nodes, n_dimensions, n_dofs, n_training_points
    integer(c_int) :: has_full_order_multipliers, has_full_order_displacement
  end type signorom_sizes

  !> An answer at one point. The default value of `size` belongs to this version of the module.
  type, bind(c), public :: signorom_answer
    integer(c_size_t) :: size = 112_c_size_t
    integer(c_int) :: code = 0, method = 0, cluster = 0, n_modes = 0, n_domain_contacts = 0, n_active = 0, n_iterations = 0
    integer(c_int) :: is_inside_box = 0
    real(c_double) :: distance = 0, residual = 0
    integer(c_int) :: n_solutions = 0
    real(c_double) :: bound = SIGNOROM_NO_BOUND, relative_bound = SIGNOROM_NO_BOUND
    real(c_double) :: displacement_bound = SIGNOROM_NO_BOUND, relative_displacement_bound = SIGNOROM_NO_BOUND
    integer(c_int) :: n_free_motions = 0
    real(c_double) :: error_estimate = SIGNOROM_NO_BOUND
  end type signorom_answer

  !> The caller's arrays for the answers at many points: c_loc of arrays with the target attribute. The default value of `size`
  !> belongs to this version of the module.
  type, bind(c), public :: signorom_arrays
    integer(c_size_t) :: size = 72_c_size_t
    type(c_ptr) :: answers = c_null_ptr, multipliers = c_null_ptr
    type(c_ptr) :: areas = c_null_ptr, forces = c_null_ptr, moments = c_null_ptr
    integer(c_int) :: n_nodes = 0
    type(c_ptr) :: nodes = c_null_ptr, displacement = c_null_ptr
  end type signorom_arrays

  public :: signorom_string

  public :: signorom_version, signorom_open, signorom_model_message, signorom_close, &
    signorom_get_sizes, signorom_text, signorom_get_parameter, signorom_get_contact_nodes, &
    signorom_get_contact_areas, signorom_get_force_directions, signorom_get_contact_entries, &
    signorom_contact_entry_name, signorom_get_resultants, &
    signorom_get_nodes, signorom_get_displacement_sources, signorom_get_domain_contacts, signorom_get_next_cluster, &
    signorom_create_context, signorom_message, signorom_free_context, signorom_query, &
    signorom_get_history, signorom_get_states, signorom_start, signorom_advance, signorom_get_point, &
    signorom_get_memory_size, signorom_get_memory, signorom_set_memory, &
    signorom_query_many, signorom_query_arrays, signorom_get_domain_multipliers, signorom_get_multipliers, &
    signorom_get_coordinates, &
    signorom_get_displacement, signorom_get_displacement_at, signorom_get_field_sizes, signorom_get_cells, &
    signorom_region_name, signorom_get_contact_facets, signorom_get_stresses, signorom_get_imposed_strains, &
    signorom_get_contact_fields, signorom_get_friction_fields, signorom_get_plastic_strains, signorom_get_creep_strains, &
    signorom_differentiate, signorom_get_multiplier_gradient, signorom_get_resultant_gradient, &
    signorom_get_displacement_gradient_at, signorom_get_displacement_gradient_errors

  interface
    type(c_ptr) function signorom_version() bind(c)
      import :: c_ptr
    end function signorom_version

    integer(c_int) function signorom_open(path, model) bind(c)
      import :: c_char, c_int, c_ptr
      character(c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: model
    end function signorom_open

    type(c_ptr) function signorom_model_message(model) bind(c)
      import :: c_ptr
      type(c_ptr), value :: model
    end function signorom_model_message

    subroutine signorom_close(model) bind(c)
      import :: c_ptr
      type(c_ptr), value :: model
    end subroutine signorom_close

    integer(c_int) function signorom_get_sizes(model, sizes) bind(c)
      import :: c_int, c_ptr, signorom_sizes
      type(c_ptr), value :: model
      type(signorom_sizes), intent(out) :: sizes
    end function signorom_get_sizes

    type(c_ptr) function signorom_text(model, kind) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), value :: kind
    end function signorom_text

    integer(c_int) function signorom_get_parameter(model, i, name, unit, minimum, maximum) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), value :: i
      type(c_ptr), intent(out), optional :: name
      type(c_ptr), intent(out), optional :: unit
      real(c_double), intent(out), optional :: minimum
      real(c_double), intent(out), optional :: maximum
    end function signorom_get_parameter

    integer(c_int) function signorom_get_contact_nodes(model, side, starts, tags, weights, coordinates) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), value :: side
      integer(c_int), intent(out), optional :: starts(*)
      integer(c_int), intent(out), optional :: tags(*)
      real(c_double), intent(out), optional :: weights(*)
      real(c_double), intent(out), optional :: coordinates(*)
    end function signorom_get_contact_nodes

    integer(c_int) function signorom_get_contact_areas(model, areas) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      real(c_double), intent(out) :: areas(*)
    end function signorom_get_contact_areas

    integer(c_int) function signorom_get_force_directions(model, contacts, directions) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: contacts(*)
      real(c_double), intent(out), optional :: directions(*)
    end function signorom_get_force_directions

    integer(c_int) function signorom_get_contact_entries(model, n_entries, n_moments, entries) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: n_entries
      integer(c_int), intent(out), optional :: n_moments
      integer(c_int), intent(out), optional :: entries(*)
    end function signorom_get_contact_entries

    type(c_ptr) function signorom_contact_entry_name(model, entry) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), value :: entry
    end function signorom_contact_entry_name

    integer(c_int) function signorom_get_resultants(model, multipliers, areas, forces, moments) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      real(c_double), intent(in) :: multipliers(*)
      real(c_double), intent(out) :: areas(*)
      real(c_double), intent(out) :: forces(*)
      real(c_double), intent(out) :: moments(*)
    end function signorom_get_resultants

    integer(c_int) function signorom_get_nodes(model, tags, coordinates) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: tags(*)
      real(c_double), intent(out), optional :: coordinates(*)
    end function signorom_get_nodes

    integer(c_int) function signorom_get_displacement_sources(model, sources) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out) :: sources(*)
    end function signorom_get_displacement_sources

    integer(c_int) function signorom_get_domain_contacts(model, cluster, n, contacts) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), value :: cluster
      integer(c_int), intent(out) :: n
      integer(c_int), intent(out), optional :: contacts(*)
    end function signorom_get_domain_contacts

    integer(c_int) function signorom_get_next_cluster(model, point, cluster) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      real(c_double), intent(in) :: point(*)
      integer(c_int), intent(out) :: cluster
    end function signorom_get_next_cluster

    integer(c_int) function signorom_create_context(model, context) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      type(c_ptr), intent(out) :: context
    end function signorom_create_context

    type(c_ptr) function signorom_message(context) bind(c)
      import :: c_ptr
      type(c_ptr), value :: context
    end function signorom_message

    subroutine signorom_free_context(context) bind(c)
      import :: c_ptr
      type(c_ptr), value :: context
    end subroutine signorom_free_context

    integer(c_int) function signorom_query(context, point, answer) bind(c)
      import :: c_double, c_int, c_ptr, signorom_answer
      type(c_ptr), value :: context
      real(c_double), intent(in) :: point(*)
      type(signorom_answer), intent(inout), optional :: answer
    end function signorom_query

    integer(c_int) function signorom_get_history(model, n_given, n_times, times) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: n_given
      integer(c_int), intent(out), optional :: n_times
      real(c_double), intent(out), optional :: times(*)
    end function signorom_get_history

    integer(c_int) function signorom_get_states(context, parameters, states) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(in) :: parameters(*)
      real(c_double), intent(out) :: states(*)
    end function signorom_get_states

    integer(c_int) function signorom_start(context, parameters) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(in) :: parameters(*)
    end function signorom_start

    integer(c_int) function signorom_advance(context, time, tables, answer) bind(c)
      import :: c_double, c_int, c_ptr, signorom_answer
      type(c_ptr), value :: context
      real(c_double), value :: time
      real(c_double), intent(in), optional :: tables(*)
      type(signorom_answer), intent(inout), optional :: answer
    end function signorom_advance

    integer(c_int) function signorom_get_memory_size(model, n) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out) :: n
    end function signorom_get_memory_size

    integer(c_int) function signorom_get_memory(context, memory) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: memory(*)
    end function signorom_get_memory

    integer(c_int) function signorom_set_memory(context, memory) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(in) :: memory(*)
    end function signorom_set_memory

    integer(c_int) function signorom_get_point(context, point) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: point(*)
    end function signorom_get_point

    integer(c_int) function signorom_query_many(context, n, points, answers, multipliers) bind(c)
      import :: c_double, c_int, c_ptr, signorom_answer
      type(c_ptr), value :: context
      integer(c_int), value :: n
      real(c_double), intent(in) :: points(*)
      type(signorom_answer), intent(inout), optional :: answers(*)
      real(c_double), intent(out), optional :: multipliers(*)
    end function signorom_query_many

    integer(c_int) function signorom_query_arrays(context, n, points, arrays) bind(c)
      import :: c_double, c_int, c_ptr, signorom_arrays
      type(c_ptr), value :: context
      integer(c_int), value :: n
      real(c_double), intent(in) :: points(*)
      type(signorom_arrays), intent(in) :: arrays
    end function signorom_query_arrays

    integer(c_int) function signorom_get_domain_multipliers(context, multipliers) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: multipliers(*)
    end function signorom_get_domain_multipliers

    integer(c_int) function signorom_get_multipliers(context, multipliers) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: multipliers(*)
    end function signorom_get_multipliers

    integer(c_int) function signorom_get_coordinates(context, coordinates) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: coordinates(*)
    end function signorom_get_coordinates

    integer(c_int) function signorom_get_displacement(context, displacement) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: displacement(*)
    end function signorom_get_displacement

    integer(c_int) function signorom_get_displacement_at(context, n, nodes, displacement) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      integer(c_int), value :: n
      integer(c_int), intent(in) :: nodes(*)
      real(c_double), intent(out) :: displacement(*)
    end function signorom_get_displacement_at

    integer(c_int) function signorom_get_field_sizes(model, n_cells, n_cell_nodes, n_regions, n_facets, n_facet_nodes) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: n_cells
      integer(c_int), intent(out), optional :: n_cell_nodes
      integer(c_int), intent(out), optional :: n_regions
      integer(c_int), intent(out), optional :: n_facets
      integer(c_int), intent(out), optional :: n_facet_nodes
    end function signorom_get_field_sizes

    integer(c_int) function signorom_get_cells(model, starts, nodes, regions) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: starts(*)
      integer(c_int), intent(out), optional :: nodes(*)
      integer(c_int), intent(out), optional :: regions(*)
    end function signorom_get_cells

    type(c_ptr) function signorom_region_name(model, region) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), value :: region
    end function signorom_region_name

    integer(c_int) function signorom_get_contact_facets(model, starts, nodes, contacts) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: model
      integer(c_int), intent(out), optional :: starts(*)
      integer(c_int), intent(out), optional :: nodes(*)
      integer(c_int), intent(out), optional :: contacts(*)
    end function signorom_get_contact_facets

    integer(c_int) function signorom_get_stresses(context, stress, von_mises, nodal_stress, nodal_von_mises) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out), optional :: stress(*)
      real(c_double), intent(out), optional :: von_mises(*)
      real(c_double), intent(out), optional :: nodal_stress(*)
      real(c_double), intent(out), optional :: nodal_von_mises(*)
    end function signorom_get_stresses

    integer(c_int) function signorom_get_imposed_strains(context, strain) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: strain(*)
    end function signorom_get_imposed_strains

    integer(c_int) function signorom_get_contact_fields(context, force, pressure, gap, status, cell_status) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out), optional :: force(*)
      real(c_double), intent(out), optional :: pressure(*)
      real(c_double), intent(out), optional :: gap(*)
      integer(c_int), intent(out), optional :: status(*)
      integer(c_int), intent(out), optional :: cell_status(*)
    end function signorom_get_contact_fields

    integer(c_int) function signorom_get_friction_fields(context, traction, slip, status) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out), optional :: traction(*)
      real(c_double), intent(out), optional :: slip(*)
      integer(c_int), intent(out), optional :: status(*)
    end function signorom_get_friction_fields

    integer(c_int) function signorom_get_plastic_strains(context, strain, tensor, nodal_strain) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out), optional :: strain(*)
      real(c_double), intent(out), optional :: tensor(*)
      real(c_double), intent(out), optional :: nodal_strain(*)
    end function signorom_get_plastic_strains

    integer(c_int) function signorom_get_creep_strains(context, strain, tensor, nodal_strain) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out), optional :: strain(*)
      real(c_double), intent(out), optional :: tensor(*)
      real(c_double), intent(out), optional :: nodal_strain(*)
    end function signorom_get_creep_strains

    integer(c_int) function signorom_differentiate(context, direction, n_grazing, is_one_sided) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: context
      integer(c_int), value :: direction
      integer(c_int), intent(out), optional :: n_grazing
      integer(c_int), intent(out), optional :: is_one_sided(*)
    end function signorom_differentiate

    integer(c_int) function signorom_get_multiplier_gradient(context, gradient) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: gradient(*)
    end function signorom_get_multiplier_gradient

    integer(c_int) function signorom_get_resultant_gradient(context, forces, moments) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: forces(*)
      real(c_double), intent(out) :: moments(*)
    end function signorom_get_resultant_gradient

    integer(c_int) function signorom_get_displacement_gradient_at(context, n, nodes, gradient) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      integer(c_int), value :: n
      integer(c_int), intent(in) :: nodes(*)
      real(c_double), intent(out) :: gradient(*)
    end function signorom_get_displacement_gradient_at

    integer(c_int) function signorom_get_displacement_gradient_errors(context, errors) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: context
      real(c_double), intent(out) :: errors(*)
    end function signorom_get_displacement_gradient_errors
  end interface

  interface
    integer(c_size_t) function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function strlen
  end interface

contains

  !> Returns a text of the library as a Fortran string; the string is empty for a null pointer.
  function signorom_string(text) result(string)
    type(c_ptr), intent(in) :: text
    character(:), allocatable :: string
    character(c_char), pointer :: characters(:)
    integer :: i

    if (.not. c_associated(text)) then
      string = ''
      return
    end if
    call c_f_pointer(text, characters, [strlen(text)])
    allocate (character(size(characters)) :: string)
    do i = 1, size(characters)
      string(i:i) = characters(i)
    end do
  end function signorom_string
end module signorom
