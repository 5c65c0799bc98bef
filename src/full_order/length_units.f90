! SPDX-License-Identifier: BSD-3-Clause
!> Units of length that decks and mesh files may have.
module sig_length_units
  use sig_deck_config, only: deck_config_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: length_factor

contains

  !> Returns the factor that converts a length of the mesh file into the deck's unit of length.
  pure real(rk) function length_factor(deck)
    type(deck_config_t), intent(in) :: deck

    length_factor = meters(deck%mesh%length_unit) / meters(deck%units%length)
  end function length_factor

  !> Returns a unit of length in meters; 1 for all names but cm, mm and um.
  pure real(rk) function meters(unit)
    character(*), intent(in) :: unit

    select case (unit)
    case ('cm')
      meters = 1.0e-2_rk
    case ('mm')
      meters = 1.0e-3_rk
    case ('um')
      meters = 1.0e-6_rk
    case default
      meters = 1
    end select
  end function meters
end module sig_length_units
