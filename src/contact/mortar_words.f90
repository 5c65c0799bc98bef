! SPDX-License-Identifier: BSD-3-Clause
!> Texts about a mortar contact: how much of its first surface faces the second, gaps, shares.
module sig_mortar_words
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_rounding, only: rounding_of_data
  use sig_surface_geometry, only: direction_text, flat_direction, is_flat
  use sig_surface_pair, only: surface_pair_t
  use sig_text, only: fine_digits, short_number
  implicit none(type, external)
  private
  public :: cover_text, gap_text, far_text, finer_text, flat_text, largest_share

contains

  !> Returns a text such as `96.2 % of 'plate_top' faces 'foot'`, followed by the share of the first surface that faces the second
  !> one beyond `limit`, and the share that is lost (mortar_sums_t), each only if it is not zero.
  pure function cover_text(surfaces, sums, limit) result(text)
    type(surface_pair_t), intent(in) :: surfaces
    type(mortar_sums_t), intent(in) :: sums
    !> [length] search distance
    real(rk), intent(in) :: limit
    character(:), allocatable :: text

    associate (entry => surfaces%entry)
      text = percent_text(sums%covered, sums) // " of '" // entry%first%text // "' faces '" // entry%second%text // "'"
      if (sums%far > 0) text = text // ', ' // percent_text(sums%far, sums) // ' beyond the search distance of ' // &
        short_number(limit, fine_digits) // ', where no contact is possible (search_distance)'
      if (sums%lost > 0) text = text // ', ' // percent_text(sums%lost, sums) // ' in facets of which only a small part ' // &
        'faces it, where no contact is possible'
    end associate
  end function cover_text

  !> Returns an area as a percentage of the first surface, at most 100: on curved facets the points of the parts give a slightly
  !> different area than those of the whole.
  pure function percent_text(area, sums) result(text)
    !> [length**2, length in the plane]
    real(rk), intent(in) :: area
    type(mortar_sums_t), intent(in) :: sums
    character(:), allocatable :: text

    text = short_number(min(100.0_rk, 100 * area / sums%whole), fine_digits) // ' %'
  end function percent_text

  !> Returns the smallest and the largest gap of the mesh, without initial_gap, as a text such as `, gaps of 0.0 to 0.02 in the
  !> mesh`, also if both are equal. Requires: at least one gap.
  pure function gap_text(gaps, extent) result(text)
    !> [length] gaps of the rows
    real(rk), intent(in) :: gaps(:)
    !> [length] longest edge of the first surface: an end of the range whose size is below 1e-9 of it is rounding and becomes 0
    real(rk), intent(in) :: extent
    character(:), allocatable :: text
    real(rk) :: ends(2)

    ends = [minval(gaps), maxval(gaps)]
    where (abs(ends) < rounding_of_data * extent) ends = 0
    text = ', gaps of ' // short_number(ends(1), fine_digits) // ' to ' // short_number(ends(2), fine_digits) // &
      ' in the mesh'
  end function gap_text

  !> Returns the largest share [-], in size, of a node of the second side in any row.
  pure real(rk) function largest_share(rows) result(largest)
    type(contact_rows_t), intent(in) :: rows
    integer :: i

    largest = 0
    associate (coefficients => reshape(rows%coefficients, [rows%n_dim, size(rows%coefficients) / rows%n_dim]))
      do i = 1, rows%n_rows
        associate (second => coefficients(:, rows%splits(i) / rows%n_dim + 1:rows%offsets(i + 1) / rows%n_dim))
          largest = max(largest, maxval(norm2(second, dim=1)))
        end associate
      end do
    end associate
  end function largest_share

  !> Returns a note if the longest edge of the first surface is longer than that of the second one; otherwise empty. It is also
  !> empty if the sides were swapped, because then only this order is possible.
  pure function finer_text(surfaces, first, second, is_swapped) result(text)
    type(surface_pair_t), intent(in) :: surfaces
    type(mortar_side_t), intent(in) :: first, second
    !> the first surface is the deck's second one
    logical, intent(in) :: is_swapped
    character(:), allocatable :: text

    text = ''
    if (first%longest > second%longest .and. .not. is_swapped) text = "; '" // surfaces%entry%first%text // &
      "' has the longer edges: contact is more accurate with the finer surface as first"
  end function finer_text

  !> Returns a note if the second surface is flat and the first one is not, and the deck gives no direction; otherwise empty. The
  !> contact normals are then those of the curved surface, which are wrong where bodies move far. The note has the direction that
  !> the deck should give: from the deck's first surface to its second one.
  pure function flat_text(surfaces, is_swapped) result(text)
    type(surface_pair_t), intent(in) :: surfaces
    !> the first surface is the deck's second one
    logical, intent(in) :: is_swapped
    character(:), allocatable :: text
    real(rk), allocatable :: direction(:)

    text = ''
    if (surfaces%entry%has_direction .or. .not. is_flat(surfaces%second_geometry) .or. is_flat(surfaces%first_geometry)) return
    direction = flat_direction(surfaces%second_geometry)
    if (is_swapped) direction = -direction
    text = "; '" // surfaces%entry%second%text // "' is flat and '" // surfaces%entry%first%text // "' is not: direction: " // &
      direction_text(direction) // ' in this entry is more accurate where the bodies move far'
  end function flat_text

  !> Returns ` within the search distance (search_distance)` if some part of the first surface faces the second one beyond it;
  !> otherwise empty.
  pure function far_text(sums) result(text)
    type(mortar_sums_t), intent(in) :: sums
    character(:), allocatable :: text

    text = ''
    if (sums%far > 0) text = ' within the search distance (search_distance)'
  end function far_text
end module sig_mortar_words
