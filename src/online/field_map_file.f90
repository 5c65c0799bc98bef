! SPDX-License-Identifier: BSD-3-Clause
!> The group /fields of model.h5, which exists where the deck asked for fields, and the check that its data fit the model.
module sig_field_map_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_contact_rows, only: contact_rows_t
  use sig_element_types, only: element_type_with
  use sig_elasticity, only: n_stresses
  use sig_errors, only: error_t
  use sig_field_map, only: field_map_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_mechanical_models, only: mechanical_model
  use sig_shape_checks, only: are_indices, is_matrix
  use sig_strain_map, only: strain_map_t
  use sig_term_check, only: are_sound_terms
  use sig_term_file, only: read_terms, write_terms
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: write_field_map, read_field_map, field_map_fits

contains

  !> Writes the group /fields; nothing if the map is empty. A failure of the file is reported when the file is closed.
  subroutine write_field_map(file, map, length)
    type(h5_writer_t), intent(inout) :: file
    type(field_map_t), intent(in) :: map
    !> name of the unit of lengths
    character(*), intent(in) :: length

    if (.not. map%is_there()) return
    call file%write('/fields/mechanics', trim(map%mechanics%name), description='mechanical model')
    call file%write('/fields/units/stress', map%stress_unit)
    call file%write('/fields/units/area', map%area_unit)
    call file%write('/fields/region_names', map%region_names)
    call file%write('/fields/regions', map%regions, description='region (1-based) of each cell; 0: none')
    call file%write('/fields/surface/starts', map%facet_starts, description= &
      'facets of the first surfaces of all contacts: facet i, from 0, has the entries starts(i) ... starts(i + 1) - 1 of nodes')
    call file%write('/fields/surface/nodes', map%facet_nodes, description='nodes (1-based) of the contact facets')
    call file%write('/fields/surface/entries', map%facet_entries, description='entry (1-based) of the deck''s contact ' // &
      'section for each facet')
    call file%write('/fields/rows/offsets', map%force_rows%offsets, description='contact row i (from 0) has the entries ' // &
      'offsets(i) ... offsets(i + 1) - 1 of dofs and coefficients')
    call file%write('/fields/rows/splits', map%force_rows%splits, description='entries of contact row i below splits(i) ' // &
      'belong to its first side')
    call file%write('/fields/rows/dofs', map%force_rows%dofs, description='dofs (1-based) of the contact rows')
    call file%write('/fields/rows/coefficients', map%force_rows%coefficients, '1')
    call write_strain_map(file, '/fields/cells', map%of_cells, length)
    call write_strain_map(file, '/fields/nodes', map%of_nodes, length)
    call write_terms(file, '/fields/terms', map%terms, length)
    call file%write('/fields/constant_terms', map%constant_terms, description= &
      'terms of Young''s modulus and Poisson''s ratio of the first material, of the second, ..., 1-based')
  end subroutine write_field_map

  subroutine write_strain_map(file, group, map, length)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(strain_map_t), intent(in) :: map
    character(*), intent(in) :: length

    call file%write(group // '/starts', map%starts, description= &
      'row i (from 0) has the entries starts(i) ... starts(i + 1) - 1 of nodes and gradients')
    call file%write(group // '/nodes', map%nodes, description='node (1-based) of each entry; nodes of a cell in gmsh''s order')
    call file%write(group // '/gradients', map%gradients, '1/' // length, &
      'the displacement gradient of a row is the sum of u g'' over its entries, a g per row; in axisymmetry the last is N / r')
    call file%write(group // '/materials', map%materials, description='material (1-based) of each row, in the order of the deck')
    call file%write(group // '/imposed', map%imposed, '1', 'imposed strains, one per row: xx, yy, zz, xy, yz, xz, shears as angles')
    call file%write(group // '/imposed_rows', map%imposed_rows, description='row (1-based) that each of these strains is ' // &
      'imposed on')
    call file%write(group // '/imposed_terms', map%imposed_terms, description='term (1-based) that is the factor of each of ' // &
      'these strains')
    if (size(map%points) == 0) return
    call file%write(group // '/point_starts', map%point_starts, description= &
      'row i (from 0) has the entries point_starts(i) ... point_starts(i + 1) - 1 of points and point_weights')
    call file%write(group // '/points', map%points, description='integration point (1-based) of cells that flow')
    call file%write(group // '/point_weights', map%point_weights, '1', 'weight of the value at each of these points')
  end subroutine write_strain_map

  !> Reads the group /fields; the map stays empty if the file has no such group. Gaps, areas and entries of the contact rows are not
  !> in the group: the caller copies them from the model, and makes `rows`. Does nothing if `error` is allocated before. Errors: a
  !> dataset is missing, or has another type or rank; the number of sources of the terms is not the one that the file says.
  subroutine read_field_map(file, path, parameter_names, map, error)
    type(h5_reader_t), intent(in) :: file
    !> name of the file for messages
    character(*), intent(in) :: path
    !> names of the model's parameters
    type(string_t), intent(in) :: parameter_names(:)
    type(field_map_t), intent(inout) :: map
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: mechanics

    if (.not. file%has('/fields') .or. allocated(error)) return
    call file%read('/fields/mechanics', mechanics, error)
    map%mechanics = mechanical_model(mechanics)
    call file%read('/fields/units/stress', map%stress_unit, error)
    call file%read('/fields/units/area', map%area_unit, error)
    call file%read('/fields/region_names', map%region_names, error)
    call file%read('/fields/regions', map%regions, error)
    call file%read('/fields/surface/starts', map%facet_starts, error)
    call file%read('/fields/surface/nodes', map%facet_nodes, error)
    call file%read('/fields/surface/entries', map%facet_entries, error)
    call file%read('/fields/rows/offsets', map%force_rows%offsets, error)
    call file%read('/fields/rows/splits', map%force_rows%splits, error)
    call file%read('/fields/rows/dofs', map%force_rows%dofs, error)
    call file%read('/fields/rows/coefficients', map%force_rows%coefficients, error)
    map%force_rows%n_dim = map%mechanics%n_dim
    map%force_rows%n_rows = size(map%force_rows%splits)
    call read_strain_map(file, '/fields/cells', map%of_cells, error)
    call read_strain_map(file, '/fields/nodes', map%of_nodes, error)
    call read_terms(file, '/fields/terms', path, parameter_names, map%terms, error)
    call file%read('/fields/constant_terms', map%constant_terms, error)
  end subroutine read_field_map

  subroutine read_strain_map(file, group, map, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(strain_map_t), intent(inout) :: map
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/starts', map%starts, error)
    call file%read(group // '/nodes', map%nodes, error)
    call file%read(group // '/gradients', map%gradients, error)
    call file%read(group // '/materials', map%materials, error)
    call file%read(group // '/imposed', map%imposed, error)
    call file%read(group // '/imposed_rows', map%imposed_rows, error)
    call file%read(group // '/imposed_terms', map%imposed_terms, error)
    if (allocated(error)) return
    if (file%has(group // '/point_starts')) then
      call file%read(group // '/point_starts', map%point_starts, error)
      call file%read(group // '/points', map%points, error)
      call file%read(group // '/point_weights', map%point_weights, error)
    else
      allocate (map%point_starts(size(map%materials) + 1), source=0)
      allocate (map%points(0), map%point_weights(0))
    end if
  end subroutine read_strain_map

  !> Whether the map is empty or fits the model: shapes fit, indices point at existing data, and numbers are finite. A model file
  !> may come from anywhere, so nothing is taken for granted. But gaps, areas and entries of the contact rows, which are copied from
  !> the model, and texts of expressions are not checked here.
  pure logical function field_map_fits(map, n_dim, n_nodes, n_multipliers, n_entries) result(fits)
    type(field_map_t), intent(in) :: map
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_nodes
    integer, intent(in) :: n_multipliers
    !> number of entries of the deck's contact section
    integer, intent(in) :: n_entries
    integer :: n_materials

    fits = .true.
    if (.not. map%is_there()) return
    n_materials = size(map%constant_terms) / 2
    fits = map%mechanics%n_dim == n_dim .and. modulo(size(map%constant_terms), 2) == 0 .and. are_sound_terms(map%terms, n_dim)
    if (fits) fits = are_indices(map%constant_terms, map%terms%n_terms())
    if (fits) fits = strain_map_fits(map%of_cells, size(map%regions), n_nodes, n_materials, map%terms%n_terms()) .and. &
      strain_map_fits(map%of_nodes, n_nodes, n_nodes, n_materials, map%terms%n_terms())
    if (fits) fits = are_elements(map%of_cells%starts, n_dim) .and. &
      all(map%regions >= 0 .and. map%regions <= size(map%region_names))
    if (fits) fits = are_lists(map%facet_starts, size(map%facet_nodes)) .and. are_indices(map%facet_nodes, n_nodes) .and. &
      size(map%facet_entries) == size(map%facet_starts) - 1 .and. are_indices(map%facet_entries, n_entries)
    if (fits) fits = are_elements(map%facet_starts, n_dim - 1) .and. rows_fit(map%force_rows, n_dim * n_nodes, n_multipliers)
  end function field_map_fits

  pure logical function strain_map_fits(map, n_rows, n_nodes, n_materials, n_terms) result(fits)
    type(strain_map_t), intent(in) :: map
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_nodes
    integer, intent(in) :: n_materials
    integer, intent(in) :: n_terms

    fits = size(map%point_starts) == n_rows + 1 .and. size(map%points) == size(map%point_weights) .and. &
      are_lists(map%point_starts, size(map%points)) .and. all(map%points >= 1) .and. all(ieee_is_finite(map%point_weights))
    if (.not. fits) return
    fits = size(map%starts) == n_rows + 1 .and. size(map%materials) == n_rows .and. are_lists(map%starts, size(map%nodes))
    if (fits) fits = are_indices(map%nodes, n_nodes) .and. is_matrix(map%gradients, 3, size(map%nodes)) .and. &
      all(map%materials >= 0 .and. map%materials <= n_materials)
    if (fits) fits = size(map%imposed_terms) == size(map%imposed_rows) .and. are_indices(map%imposed_rows, n_rows) .and. &
      are_indices(map%imposed_terms, n_terms) .and. is_matrix(map%imposed, n_stresses, size(map%imposed_rows))
  end function strain_map_fits

  !> Whether `starts` divides n entries into lists: it begins with 0, never decreases and ends with n.
  pure logical function are_lists(starts, n)
    integer, intent(in) :: starts(:)
    integer, intent(in) :: n

    are_lists = size(starts) >= 1
    if (.not. are_lists) return
    are_lists = all(starts >= 0 .and. starts <= n) .and. starts(1) == 0 .and. starts(size(starts)) == n .and. &
      all(starts(2:) >= starts(:size(starts) - 1))
  end function are_lists

  !> Whether each of the lists that `starts` describes (are_lists) has as many entries as some element type of dimension n_dim has
  !> nodes.
  pure logical function are_elements(starts, n_dim)
    integer, intent(in) :: starts(:)
    integer, intent(in) :: n_dim
    integer :: i

    are_elements = all([(element_type_with(n_dim, starts(i + 1) - starts(i)) > 0, i=1, size(starts) - 1)])
  end function are_elements

  !> Whether the contact rows fit the model: there are n_multipliers of them, each consists of whole nodes of the model (all dofs of
  !> a node in order), and at least one of these nodes is on the first side. The coefficients are finite, and those of the first
  !> node are not all zero.
  pure logical function rows_fit(rows, n_dofs, n_multipliers)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers
    integer :: i

    associate (n => rows%n_rows)
      rows_fit = n == n_multipliers .and. size(rows%offsets) == n + 1 .and. size(rows%coefficients) == size(rows%dofs)
      if (rows_fit) rows_fit = are_lists(rows%offsets, size(rows%dofs)) .and. are_indices(rows%dofs, n_dofs) .and. &
        all(ieee_is_finite(rows%coefficients))
      if (rows_fit) rows_fit = all(rows%splits > rows%offsets(:n) .and. rows%splits <= rows%offsets(2:)) .and. &
        all(modulo([rows%offsets, rows%splits], rows%n_dim) == 0)
    end associate
    if (rows_fit) rows_fit = all([(rows%dofs(i) == rows%dofs(i - modulo(i - 1, rows%n_dim)) + modulo(i - 1, rows%n_dim), &
      i=1, size(rows%dofs))]) .and. all(modulo(rows%dofs(1::rows%n_dim) - 1, rows%n_dim) == 0)
    ! normals are divided by the length of the owner's coefficients, so it must not be zero
    associate (first => rows%offsets, n_dim => rows%n_dim)
      if (rows_fit) rows_fit = all([(norm2(rows%coefficients(first(i) + 1:first(i) + n_dim)) > 0, i=1, rows%n_rows)])
    end associate
  end function rows_fit
end module sig_field_map_file
