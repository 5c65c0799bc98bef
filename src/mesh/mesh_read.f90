! SPDX-License-Identifier: BSD-3-Clause
!> Reads a gmsh file and returns a checked mesh, on one rank.
module sig_mesh_read
  use sig_cell_quality, only: orient_cells
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_build, only: build_mesh, mesh_dimension
  use sig_mesh_file, only: raw_mesh_t, read_raw_mesh
  implicit none(type, external)
  private
  public :: read_mesh

contains

  !> Reads a gmsh file and returns a checked mesh with file_hash. Local. Errors: those of read_raw_mesh, build_mesh, orient_cells
  !> and check_boundary; then `mesh` must not be used.
  subroutine read_mesh(path, n_dim, length_factor, mesh, error)
    character(*), intent(in) :: path
    !> 2 or 3: dimension of the model; 0: the largest dimension of the elements, but at least 2
    integer, intent(in) :: n_dim
    !> factor for all coordinates [units.length / mesh.length_unit]
    real(rk), intent(in) :: length_factor
    type(mesh_t), intent(out) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(raw_mesh_t) :: raw
    integer :: n_model

    call read_raw_mesh(path, raw, error)
    if (allocated(error)) return
    n_model = n_dim
    if (n_dim == 0) n_model = max(2, mesh_dimension(raw))
    call build_mesh(raw, n_model, length_factor, path, mesh, error)
    if (allocated(error)) return
    mesh%file_hash = raw%hash
    call orient_cells(mesh, path, error)
    if (allocated(error)) return
    call check_boundary(mesh, path, error)
  end subroutine read_mesh

  !> Checks that something besides regions has a name: supports, loads and contacts need it. Errors: there are only regions.
  pure subroutine check_boundary(mesh, path, error)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    if (any(mesh%groups%n_dim < mesh%n_dim)) return
    call make_error(error, 'the mesh has no elements on its boundary, so that supports, loads and contacts have no place', path, &
      hint='save them, too: in gmsh put the boundaries in physical groups, or nothing at all. From this file alone gmsh finds ' // &
      'them, divided at edges sharper than 40 degrees, and writes divided.msh: gmsh ' // &
      path(index(path, '/', back=.true.) + 1:) // ' -save -format msh22 -o plain.msh; echo ''Merge "plain.msh"; ' // &
      'CreateTopology; ClassifySurfaces{40*Pi/180, 1, 0, 40*Pi/180};'' > divide.geo; ' // &
      'gmsh divide.geo -save -setnumber Mesh.SaveAll 1 -format msh41 -o divided.msh')
  end subroutine check_boundary
end module sig_mesh_read
