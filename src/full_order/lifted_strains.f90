! SPDX-License-Identifier: BSD-3-Clause
!> Finds what imposed strains add to the lifting of a reduced model, beside prescribed displacements: forces and terms.
!>
!> The imposed strains are sum over s of theta_s(mu) eps_s. The lifting has the elastic response to each eps_s, for the stiffness in
!> the middle of the box. If the stiffness depends on the parameters, theta_s times this response is only near the response at mu.
!> This is good enough for a lifting: the free expansion of a body does not depend on its modulus.
module sig_lifted_strains
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_elastic_body, only: elastic_body_t
  use sig_imposed_strain, only: imposed_strains_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_strain_force, only: strain_forces
  use sig_term_set, only: term_set_t
  implicit none(type, external)
  private
  public :: lift_strains

contains

  !> Gives the boundary conditions one field of lifted forces for each term theta_s of the imposed strains that causes forces, and
  !> lists all terms for which the lifting has a column. Local.
  subroutine lift_strains(mesh, body, strains, n_first, terms, boundary, lifted_terms)
    type(mesh_t), intent(in) :: mesh
    !> with its elastic constants in the middle of the box
    type(elastic_body_t), intent(in) :: body
    type(imposed_strains_t), intent(in) :: strains
    !> the first n_first terms of the problem are not searched for theta_s (theta_1 = 1 is always the problem's term 1)
    integer, intent(in) :: n_first
    !> terms of the problem; a theta_s that is not found is added, for example where the forces of the strains have a modulus as a
    !> factor
    type(term_set_t), intent(inout) :: terms
    !> gets the forces of each theta_s as lifted forces
    type(boundary_conditions_t), intent(inout) :: boundary
    !> indices of the problem's terms: those of the prescribed displacements, then the theta_s
    integer, allocatable, intent(out) :: lifted_terms(:)
    real(rk) :: forces(mesh%n_dim * mesh%n_nodes), own(mesh%n_dim * mesh%n_nodes)
    integer :: i, i_last, n, s

    lifted_terms = [(i, i=1, size(boundary%prescribed_values, 2))]
    if (.not. strains%are_there()) return
    n = 0
    do s = 1, strains%terms%n_terms()
      forces = 0
      i_last = 0
      do i = 1, size(strains%parts)
        if (strains%parts(i)%term /= s) cycle
        i_last = i
        call strain_forces(mesh, body, strains%parts(i), body%stress_matrix(:, :, strains%parts(i)%material), own)
        forces = forces + own
      end do
      if (.not. any(abs(forces) > 0)) cycle
      n = n + 1
      call boundary%lifted_forces%add_forces(n, forces)
      lifted_terms = [lifted_terms, term_of(strains, s, i_last, n_first, terms)]
    end do
  end subroutine lift_strains

  !> Returns the index of the problem's term with the same expression as term s of the strains; 1 for s = 1. If there is none behind
  !> the first n_first terms, it is added.
  integer function term_of(strains, s, i_part, n_first, terms) result(i_term)
    type(imposed_strains_t), intent(in) :: strains
    !> term of the strains, 1-based
    integer, intent(in) :: s
    !> index in strains%parts of a part with this term, for the place in the deck
    integer, intent(in) :: i_part
    !> as in lift_strains
    integer, intent(in) :: n_first
    type(term_set_t), intent(inout) :: terms

    i_term = 1
    if (s == 1) return
    associate (text => strains%terms%names(s)%text, part => strains%parts(i_part))
      do i_term = n_first + 1, terms%n_terms()
        if (terms%names(i_term)%text == text) return
      end do
      call terms%add_expression(text, part%line, part%column, i_term)
    end associate
  end function term_of
end module sig_lifted_strains
