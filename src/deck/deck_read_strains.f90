! SPDX-License-Identifier: BSD-3-Clause
!> Reads the section `imposed_strains` of a deck: strains from temperatures or swelling that a region would have if nothing held it.
module sig_deck_read_strains
  use sig_deck_config, only: field_config_t, imposed_strain_config_t, value_config_t
  use sig_deck_tree, only: append_text, deck_tree_t, kind_mapping, root_node
  use sig_deck_values, only: get_choice, get_list_entries, get_mapping, get_name, get_value, get_word, is_mapping, value_of
  use sig_mechanical_models, only: mechanical_model_t, mechanical_models
  use sig_text, only: join, string_t
  implicit none(type, external)
  private
  public :: read_imposed_strains

  character(*), parameter :: of_place = 'a number or an expression of the parameters and the coordinates'
  character(*), parameter :: of_parameters = 'a number or an expression of the parameters'
  character(*), parameter :: quantities(2) = [character(11) :: 'temperature', 'strain']

contains

  !> Reads the section imposed_strains, one element of `strains` per entry; none without the section. The caller sets field%path.
  !> Errors: an unknown key, a value that is missing or faulty (a harmless value stands in its place).
  subroutine read_imposed_strains(tree, model, strains)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(mechanical_model_t), intent(in) :: model
    type(imposed_strain_config_t), allocatable, intent(out) :: strains(:)
    integer, allocatable :: nodes(:)
    integer :: i

    call get_list_entries(tree, root_node, 'imposed_strains', .false., .true., nodes)
    allocate (strains(size(nodes)))
    do i = 1, size(nodes)
      strains(i)%region%text = ''
      strains(i)%value%text = '0'
      strains(i)%reference%text = '0'
      strains(i)%field%file = ''
      strains(i)%field%name%text = ''
      if (.not. is_mapping(tree, nodes(i))) cycle
      call get_name(tree, nodes(i), 'region', strains(i)%region)
      call read_entry(tree, nodes(i), model, strains(i))
      call tree%close_mapping(nodes(i))
    end do
  end subroutine read_imposed_strains

  !> Reads an entry: exactly one of temperature, field and strain, and the reference, which a temperature needs (also from a field)
  !> and a strain must not have.
  subroutine read_entry(tree, i_entry, model, strain)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(mechanical_model_t), intent(in) :: model
    type(imposed_strain_config_t), intent(inout) :: strain
    integer :: i_field, i_strain, i_temperature

    i_temperature = tree%find(i_entry, 'temperature')
    i_field = tree%find(i_entry, 'field')
    i_strain = tree%find(i_entry, 'strain')
    if (count([i_temperature, i_field, i_strain] > 0) /= 1) then
      call tree%report(i_entry, 'must have exactly one of temperature, field and strain')
      call forget_rest(tree, i_entry)
      return
    end if
    strain%is_thermal = i_strain == 0
    strain%has_field = i_field > 0
    if (i_temperature > 0) call read_value(tree, i_temperature, of_place, .true., strain%value)
    if (i_field > 0) call read_field(tree, i_entry, strain)
    if (i_strain > 0) call read_strain(tree, i_strain, model, strain)
    if (.not. strain%is_thermal) then
      call tree%refuse_key(i_entry, 'reference', 'the entry gives the strain itself and no temperature')
    else if (tree%find(i_entry, 'reference') == 0) then
      call tree%report_key(i_entry, tree%key_path(i_entry) // '.reference is missing: the temperature without strain')
    else
      call get_value(tree, i_entry, 'reference', strain%reference)
    end if
  end subroutine read_entry

  !> Marks the keys reference and factor of an entry as known after an error, so that they cause no further errors.
  subroutine forget_rest(tree, i_entry)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    integer :: ignored

    ignored = tree%find(i_entry, 'reference')
    ignored = tree%find(i_entry, 'factor')
  end subroutine forget_rest

  !> Reads file and name of a field, its quantity (temperature, the default, makes is_thermal true, strain makes it false), and the
  !> factor of its values, by default 1.
  subroutine read_field(tree, i_entry, strain)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(imposed_strain_config_t), intent(inout) :: strain
    character(:), allocatable :: quantity
    integer :: i_factor, i_field

    i_field = get_mapping(tree, i_entry, 'field', .true.)
    if (i_field > 0) then
      call read_source(tree, i_field, strain%field)
      quantity = trim(quantities(1))
      call get_choice(tree, i_field, 'quantity', .false., quantities, quantity)
      strain%is_thermal = quantity == quantities(1)
      call tree%close_mapping(i_field)
    end if
    strain%value%text = '1'
    strain%value%constant = 1
    i_factor = tree%find(i_entry, 'factor')
    if (i_factor > 0) call read_value(tree, i_factor, of_parameters, .false., strain%value)
  end subroutine read_field

  subroutine read_source(tree, i_field, field)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_field
    type(field_config_t), intent(inout) :: field
    integer :: i_file

    call get_word(tree, i_field, 'file', .true., field%file)
    call get_name(tree, i_field, 'name', field%name)
    i_file = tree%find(i_field, 'file')
    if (i_file == 0) return
    field%line = tree%nodes(i_file)%line
    field%column = tree%nodes(i_file)%column
  end subroutine read_source

  !> Reads a strain: one value for all directions into strain%value, or a mapping of components into strain%components. Errors: an
  !> empty mapping, a key that is no component of the model, faulty values.
  subroutine read_strain(tree, i_strain, model, strain)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_strain
    type(mechanical_model_t), intent(in) :: model
    type(imposed_strain_config_t), intent(inout) :: strain
    integer :: i, i_value

    if (tree%nodes(i_strain)%kind /= kind_mapping) then
      call read_value(tree, i_strain, of_place, .true., strain%value)
      return
    end if
    do i = 1, size(model%strain_names)
      if (model%strain_names(i) == '') cycle
      i_value = tree%find(i_strain, trim(model%strain_names(i)))
      strain%has_component(i) = i_value > 0
      if (i_value > 0) call read_value(tree, i_value, of_place, .true., strain%components(i))
    end do
    call refuse_other_components(tree, i_strain, model)
    call tree%close_mapping(i_strain)
    if (size(tree%children(i_strain)) == 0) call tree%report(i_strain, 'is an empty mapping; ' // strains_text(model))
  end subroutine read_strain

  !> Adds an error for each key that is a strain of another model only; it says which strains this model has.
  subroutine refuse_other_components(tree, i_mapping, model)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_mapping
    type(mechanical_model_t), intent(in) :: model
    integer, allocatable :: nodes(:)
    integer :: i, j

    nodes = tree%children(i_mapping)
    do i = 1, size(nodes)
      associate (key => tree%nodes(nodes(i))%key)
        if (any(model%strain_names == key)) cycle
        do j = 1, size(mechanical_models)
          if (.not. any(mechanical_models(j)%strain_names == key)) cycle
          call tree%report(tree%find(i_mapping, key), 'is given; ' // strains_text(model))
          exit
        end do
      end associate
    end do
  end subroutine refuse_other_components

  !> Returns `plane_stress models take the strains xx, yy, xy`.
  pure function strains_text(model) result(text)
    type(mechanical_model_t), intent(in) :: model
    character(:), allocatable :: text
    type(string_t), allocatable :: names(:)
    integer :: i

    allocate (names(0))
    do i = 1, size(model%strain_names)
      if (model%strain_names(i) /= '') call append_text(names, trim(model%strain_names(i)))
    end do
    text = trim(model%name) // ' models take the strains ' // join(names, ', ')
  end function strains_text

  !> Reads a value; the number 0 replaces a faulty one.
  subroutine read_value(tree, i_node, wanted, may_use_coordinates, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    !> as in value_of
    character(*), intent(in) :: wanted
    logical, intent(in) :: may_use_coordinates
    type(value_config_t), intent(inout) :: value
    logical :: is_valid

    call value_of(tree, i_node, wanted, value, is_valid, may_use_coordinates)
    if (.not. is_valid) value = value_config_t(text='0', line=value%line, column=value%column)
  end subroutine read_value
end module sig_deck_read_strains
