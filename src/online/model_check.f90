! SPDX-License-Identifier: BSD-3-Clause
!> Checks that the parts of a model fit together, so that queries and descriptions cannot fail on them.
module sig_model_check
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_contact_laws_file, only: laws_fit
  use sig_expression, only: is_identifier
  use sig_field_map, only: field_map_t
  use sig_field_map_file, only: field_map_fits
  use sig_history_file, only: history_fits
  use sig_kinds, only: rk
  use sig_model, only: contact_side_t, model_sizes, model_t, validation_statistics_t
  use sig_shape_checks, only: is_matrix
  use sig_term_check, only: are_sound_terms
  implicit none(type, external)
  private
  public :: find_mismatch

contains

  !> Returns the name of the data of the model (an array, a number, a group of arrays) whose shape does not fit the others, or whose
  !> values a query cannot use; empty when all fit. The name of an array of a part has the group of the part before it
  !> (`clusters/1/basis`). A model file may come from anywhere, so every value that indexes an array or controls a loop is checked
  !> here once. Requires: complete_model, or the model was read from a file.
  function find_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i

    name = ''
    if (model%n_clusters() < 1) name = 'clusters'
    if (.not. are_sound_terms(model%terms, model%n_dim)) name = 'terms'
    if (.not. is_consistent(model%validation)) name = 'validation'
    if (.not. model%max_error >= 0) name = 'max_error'
    if (len(name) == 0) name = find_size_mismatch(model)
    if (len(name) == 0) name = find_parameter_mismatch(model)
    if (len(name) == 0 .and. .not. history_fits(model%history, model%parameter_names)) name = 'history'
    if (len(name) == 0) name = find_contact_mismatch(model)
    if (len(name) == 0 .and. .not. field_map_fits(model%fields, model%n_dim, model%n_nodes, model%n_multipliers, &
      model%resultants%n_entries())) name = 'fields'
    if (len(name) > 0) return
    if (.not. model%choice%fits(model%n_clusters(), size(model%parameter_names))) name = 'choice'
    do i = 1, size(model%parts)
      if (len(name) > 0) return
      name = model%parts(i)%reduced%mismatch(model_sizes(model))
      if (len(name) > 0) then
        name = model%group_of(i) // '/' // name
      else if (.not. spreads_fit(model%fields, model%parts(i)%reduced%n_flow_points())) then
        name = 'fields'
      end if
    end do
  end function find_mismatch

  !> Whether fields ask for values at no more integration points than a part has; a part without any is not asked. Requires:
  !> field_map_fits.
  pure logical function spreads_fit(fields, n_points)
    type(field_map_t), intent(in) :: fields
    integer, intent(in) :: n_points

    spreads_fit = .true.
    if (n_points == 0 .or. .not. fields%is_there()) return
    spreads_fit = all(fields%of_cells%points <= n_points) .and. all(fields%of_nodes%points <= n_points)
  end function spreads_fit

  pure function find_size_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i

    name = ''
    if (model%n_dim /= 2 .and. model%n_dim /= 3) name = 'n_dim'
    if (model%n_nodes < 0) name = 'n_nodes'
    if (model%n_multipliers < 0) name = 'n_multipliers'
    if (len(name) > 0) return
    if (model%n_dofs / model%n_dim /= model%n_nodes .or. modulo(model%n_dofs, model%n_dim) /= 0) name = 'n_dofs'
    ! a number in the file may have any value, but there is an array of this size
    if (model%n_dofs > 0 .and. size(model%node_tags) == 0 .and. &
      .not. any([(model%parts(i)%reduced%has_whole_field(model%n_dofs), i=1, size(model%parts))])) name = 'n_dofs'
    if (all(size(model%node_tags) /= [0, model%n_nodes])) name = 'node_tags'
    if (size(model%coordinates, 2) /= size(model%node_tags) .or. size(model%coordinates, 1) /= model%n_dim) name = 'coordinates'
  end function find_size_mismatch

  pure function find_parameter_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i, n_parameters

    name = ''
    n_parameters = size(model%parameter_names)
    do i = 1, n_parameters
      if (.not. is_identifier(model%parameter_names(i)%text)) name = 'parameter_names'
    end do
    if (size(model%parameter_units) /= n_parameters) name = 'parameter_units'
    if (any(shape(model%box) /= [2, n_parameters])) name = 'box'
    if (size(model%training_points, 1) /= n_parameters .or. .not. all(ieee_is_finite(model%training_points))) &
      name = 'training_points'
    if (len(name) > 0) return
    if (.not. all(ieee_is_finite(model%box)) .or. any(model%box(1, :) > model%box(2, :))) name = 'box'
  end function find_parameter_mismatch

  pure function find_contact_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name

    name = ''
    if (.not. is_matrix(model%gap, model%n_multipliers, model%terms%n_terms())) name = 'gap'
    associate (idle => model%idle_work)
      if (.not. is_matrix(idle%work, model%terms%n_terms(), size(idle%limits, 2))) name = 'idle_motions/work'
      if (.not. is_matrix(idle%limits, model%terms%n_terms(), size(idle%work, 2))) name = 'idle_motions/limits'
    end associate
    if (size(model%areas) /= model%n_multipliers .or. .not. all(ieee_is_finite(model%areas))) name = 'contact/areas'
    if (.not. laws_fit(model%laws, model%n_multipliers, model%terms%n_terms())) name = 'contact/laws'
    if (.not. model%resultants%fits(model%n_dim, model%n_multipliers)) name = 'contact/entries'
    if (.not. is_side(model%first_side, 1, model%laws%n_contacts, model%n_dim)) name = 'contact/first'
    if (.not. is_side(model%second_side, 0, model%laws%n_contacts, model%n_dim)) name = 'contact/second'
  end function find_contact_mismatch

  !> Whether each contact has a list of at least n_least nodes, the lists follow one another, and all nodes have finite weights and
  !> coordinates. The tags may have any values.
  pure logical function is_side(side, n_least, n_contacts, n_dim)
    type(contact_side_t), intent(in) :: side
    !> least number of nodes of each contact
    integer, intent(in) :: n_least
    integer, intent(in) :: n_contacts
    integer, intent(in) :: n_dim

    is_side = .false.
    associate (starts => side%starts)
      ! a sum of arbitrary numbers could overflow
      if (size(starts) - 1 /= n_contacts) return
      if (any(starts < 0 .or. starts > size(side%tags)) .or. starts(1) /= 0 .or. starts(size(starts)) /= size(side%tags)) return
      is_side = all(starts(2:) - starts(:n_contacts) >= n_least) .and. size(side%weights) == size(side%tags) .and. &
        all(ieee_is_finite(side%weights)) .and. is_matrix(side%coordinates, n_dim, size(side%tags))
    end associate
  end function is_side

  !> Whether the arrays of the statistics have matching lengths.
  pure logical function is_consistent(validation)
    type(validation_statistics_t), intent(in) :: validation

    is_consistent = all([size(validation%minimum), size(validation%median), size(validation%p95), size(validation%maximum)] &
                        == size(validation%names)) .and. size(validation%method_counts) == size(validation%method_names)
  end function is_consistent
end module sig_model_check
