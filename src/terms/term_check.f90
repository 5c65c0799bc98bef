! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the terms that were read from a model file. A query relies on them and does not check again.
module sig_term_check
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_element_types, only: element_type_with, max_facet_nodes
  use sig_term_set, only: source_expression, source_places, source_surface, term_set_t, term_source_t
  implicit none(type, external)
  private
  public :: are_sound_terms

  !> least number of rows of the table of facets, even where facets have fewer nodes
  integer, parameter :: fewest_rows = 4

contains

  !> Whether there is at least one term, and every source is sound: its kind is known, the shapes of the arrays that this kind uses
  !> fit together and to n_dim, its places are finite, its orientations are 1 or -1, its facets are of known types, and its indices
  !> point at terms, places and coordinates that exist, or are 0 where 0 means none. The texts of expressions are not checked.
  pure logical function are_sound_terms(terms, n_dim)
    type(term_set_t), intent(in) :: terms
    !> number of coordinates, 2 or 3
    integer, intent(in) :: n_dim
    integer :: i

    are_sound_terms = terms%n_terms() >= 1
    do i = 1, size(terms%sources)
      if (are_sound_terms) are_sound_terms = is_sound_source(terms, terms%sources(i), n_dim)
    end do
  end function are_sound_terms

  pure logical function is_sound_source(terms, source, n_dim) result(is_sound)
    type(term_set_t), intent(in) :: terms
    type(term_source_t), intent(in) :: source
    integer, intent(in) :: n_dim

    is_sound = all(source%terms >= 1 .and. source%terms <= terms%n_terms())
    if (.not. is_sound) return
    select case (source%kind)
    case (source_expression)
      is_sound = size(source%terms) == 1
    case (source_places)
      is_sound = has_sound_places(terms, source, n_dim) .and. size(source%terms) == size(source%places, 2)
    case (source_surface)
      is_sound = has_sound_places(terms, source, n_dim) .and. has_sound_window(source, n_dim)
      if (is_sound) is_sound = all(shape(source%dof_terms) == shape(source%places)) .and. &
        all(source%dof_terms >= 0 .and. source%dof_terms <= terms%n_terms()) .and. &
        size(source%orientations) == size(source%facets, 2) .and. all(abs(source%orientations) == 1)
      if (is_sound) is_sound = has_sound_facets(source, n_dim)
    case default
      is_sound = .false.
    end select
  end function is_sound_source

  pure logical function has_sound_places(terms, source, n_dim)
    type(term_set_t), intent(in) :: terms
    type(term_source_t), intent(in) :: source
    integer, intent(in) :: n_dim

    has_sound_places = size(terms%coordinate_names) == n_dim .and. size(source%places, 1) == n_dim .and. &
      all(ieee_is_finite(source%places))
  end function has_sound_places

  pure logical function has_sound_window(source, n_dim)
    type(term_source_t), intent(in) :: source
    integer, intent(in) :: n_dim

    has_sound_window = source%component >= 0 .and. source%component <= n_dim .and. source%axis >= 0 .and. source%axis <= n_dim
  end function has_sound_window

  !> Whether the table of facets has 4 to max_facet_nodes rows, and each column has nodes that exist first, as many as a known edge
  !> (n_dim = 2) or face (n_dim = 3) has, then zeros.
  pure logical function has_sound_facets(source, n_dim)
    type(term_source_t), intent(in) :: source
    integer, intent(in) :: n_dim
    integer :: i, n_nodes

    has_sound_facets = size(source%facets, 1) >= fewest_rows .and. size(source%facets, 1) <= max_facet_nodes .and. &
      all(source%facets >= 0 .and. source%facets <= size(source%places, 2))
    do i = 1, size(source%facets, 2)
      if (.not. has_sound_facets) return
      n_nodes = count(source%facets(:, i) > 0)
      has_sound_facets = all(source%facets(:n_nodes, i) > 0) .and. element_type_with(n_dim - 1, n_nodes) > 0
    end do
  end function has_sound_facets
end module sig_term_check
