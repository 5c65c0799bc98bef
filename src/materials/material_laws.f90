! SPDX-License-Identifier: BSD-3-Clause
!> Makes the law of a material that flows. A new law is one file and one case here.
module sig_material_laws
  use sig_kinds, only: rk
  use sig_material_law, only: material_law_t
  use sig_norton_creep, only: norton_creep_t
  use sig_plasticity, only: plasticity_t
  use sig_plasticity_with_creep, only: plasticity_with_creep_t
  implicit none(type, external)
  private
  public :: law_names, make_law

  !> names of the laws: what files and messages call them
  character(*), parameter :: law_names(3) = [character(21) :: 'plasticity', 'norton_creep', 'plasticity_with_creep']

contains

  !> Makes a law by its name. An unknown name makes none.
  subroutine make_law(name, curve_strains, law)
    !> one of law_names
    character(*), intent(in) :: name
    !> [-] equivalent plastic strains of the hardening curve, increasing from 0; [0] = linear hardening; laws without plasticity do
    !> not read them
    real(rk), intent(in) :: curve_strains(:)
    class(material_law_t), allocatable, intent(out) :: law

    select case (name)
    case ('plasticity')
      allocate (plasticity_t :: law)
    case ('norton_creep')
      allocate (norton_creep_t :: law)
    case ('plasticity_with_creep')
      allocate (plasticity_with_creep_t :: law)
    case default
      return
    end select
    law%name = name
    law%curve_strains = curve_strains
    call law%start()
  end subroutine make_law
end module sig_material_laws
