! SPDX-License-Identifier: BSD-3-Clause
!> Computes the nodal forces that imposed strains cause, F* = integral of B' C eps*, as a sum of terms.
module sig_strain_force
  use sig_cell_stiffness, only: cell_dofs
  use sig_deck_config, only: deck_config_t, material_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: hooke_term, modulus_text, n_hooke_terms, n_stresses
  use sig_errors, only: error_t
  use sig_flow_strains, only: strain_matrices
  use sig_imposed_strain, only: imposed_strains_t, strain_part_t
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_mesh, only: mesh_t
  use sig_strain_parts, only: find_term
  use sig_term_set, only: term_set_t
  implicit none(type, external)
  private
  public :: add_strain_forces, has_numbers, strain_forces

contains

  !> Adds the forces of all parts of the imposed strains to terms and pattern. If the elastic constants of the material are numbers,
  !> a part has one term, with the expression of its strain (term 1 if the strain has no parameters). Otherwise it has two terms:
  !> the expression of its strain times the bulk modulus, and times the shear modulus. A term whose forces are all zero is left out.
  !> Parts with the same expression share one term.
  !>
  !> Errors: strain times modulus is not a valid expression, for example because it is too long.
  subroutine add_strain_forces(mesh, body, deck, strains, terms, pattern, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(deck_config_t), intent(in) :: deck
    type(imposed_strains_t), intent(in) :: strains
    !> grows by the terms of the forces
    type(term_set_t), intent(inout) :: terms
    !> gets the forces
    type(load_pattern_t), intent(inout) :: pattern
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: forces(mesh%n_dim * mesh%n_nodes), hooke(n_stresses, n_stresses)
    character(:), allocatable :: text
    integer :: i, i_hooke, i_term, n_first

    if (.not. strains%are_there()) return
    n_first = terms%n_terms()
    do i = 1, size(strains%parts)
      associate (part => strains%parts(i), material => deck%materials(strains%parts(i)%material))
        do i_hooke = 1, merge(1, n_hooke_terms, has_numbers(material))
          text = theta_text(strains, part)
          hooke = body%stress_matrix(:, :, part%material)
          if (.not. has_numbers(material)) then
            hooke = hooke_term(body%model, i_hooke)
            if (text /= '') text = '(' // text // ')*'
            text = text // modulus_text(body%model, i_hooke, material%young_modulus%text, material%poisson_ratio%text)
          end if
          call strain_forces(mesh, body, part, hooke, forces)
          if (.not. any(abs(forces) > 0)) cycle
          call find_term(terms, n_first, text, part, deck%path, i_term, error)
          if (allocated(error)) return
          call pattern%add_forces(i_term, forces)
        end do
      end associate
    end do
  end subroutine add_strain_forces

  !> Whether the elastic constants of a material do not depend on the parameters.
  elemental logical function has_numbers(material)
    type(material_config_t), intent(in) :: material

    has_numbers = material%young_modulus%is_constant .and. material%poisson_ratio%is_constant
  end function has_numbers

  !> Returns the expression of the strains' term that a part belongs to; empty for term 1.
  pure function theta_text(strains, part) result(text)
    type(imposed_strains_t), intent(in) :: strains
    type(strain_part_t), intent(in) :: part
    character(:), allocatable :: text

    text = ''
    if (part%term > 1) text = strains%terms%names(part%term)%text
  end function theta_text

  !> Computes the nodal forces of one part of the imposed strains, the integral of B' hooke eps* for theta = 1; zeros for a part
  !> without cells.
  pure subroutine strain_forces(mesh, body, part, hooke, forces)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_part_t), intent(in) :: part
    !> [force/length**2] stresses from strains, as stress_matrix or hooke_term has them
    real(rk), intent(in) :: hooke(n_stresses, n_stresses)
    !> [force] shape (n_dofs)
    real(rk), intent(out) :: forces(:)
    real(rk) :: stress(n_stresses)
    real(rk), allocatable :: strains(:, :, :), volumes(:)
    integer :: i, i_point, n

    forces = 0
    stress = matmul(hooke, part%direction)
    n = 0
    do i = 1, size(part%cells)
      associate (dofs => cell_dofs(mesh, part%cells(i)))
        call strain_matrices(mesh, body, part%cells(i), strains, volumes)
        do i_point = 1, size(volumes)
          n = n + 1
          forces(dofs) = forces(dofs) + volumes(i_point) * part%values(n) * matmul(stress, strains(:, :, i_point))
        end do
      end associate
    end do
  end subroutine strain_forces
end module sig_strain_force
