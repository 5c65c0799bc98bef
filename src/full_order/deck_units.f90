! SPDX-License-Identifier: BSD-3-Clause
!> Names of the units of the results, as the units and the mechanical model of a deck define them.
module sig_deck_units
  use sig_deck_config, only: deck_config_t
  use sig_mechanical_models, only: is_plane, mechanical_model
  implicit none(type, external)
  private
  public :: area_unit, force_unit, moment_unit, stress_unit

contains

  !> Returns the name of the unit of contact forces and reactions, such as `N`. In plane models forces are per unit thickness, such
  !> as `N/m`, in axisymmetric ones of the full turn.
  pure function force_unit(deck) result(unit)
    type(deck_config_t), intent(in) :: deck
    character(:), allocatable :: unit

    unit = deck%units%force
    if (is_plane(mechanical_model(deck%mesh%model))) unit = unit // '/' // deck%units%length
  end function force_unit

  !> Returns the name of the unit of moments, such as `N*m`. In plane models they are per unit thickness: `N*m/m`.
  pure function moment_unit(deck) result(unit)
    type(deck_config_t), intent(in) :: deck
    character(:), allocatable :: unit

    unit = deck%units%force // '*' // deck%units%length
    if (is_plane(mechanical_model(deck%mesh%model))) unit = unit // '/' // deck%units%length
  end function moment_unit

  !> Returns the name of the unit of the area of a contact: of a length in plane models, `m`, otherwise of an area, `m2`. In
  !> axisymmetric models it is the area of the full turn.
  pure function area_unit(deck) result(unit)
    type(deck_config_t), intent(in) :: deck
    character(:), allocatable :: unit

    unit = deck%units%length
    if (.not. is_plane(mechanical_model(deck%mesh%model))) unit = unit // '2'
  end function area_unit

  !> Returns the name of the unit of stresses: `Pa`, `kPa`, `MPa` or `GPa` if force / length**2 is one of these, otherwise such as
  !> `N/cm2`.
  pure function stress_unit(deck) result(unit)
    type(deck_config_t), intent(in) :: deck
    character(:), allocatable :: unit

    select case (deck%units%force // '/' // deck%units%length)
    case ('N/m')
      unit = 'Pa'
    case ('kN/m')
      unit = 'kPa'
    case ('MN/m', 'N/mm')
      unit = 'MPa'
    case ('kN/mm')
      unit = 'GPa'
    case default
      unit = deck%units%force // '/' // deck%units%length // '2'
    end select
  end function stress_unit
end module sig_deck_units
