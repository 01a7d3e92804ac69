# clamped square plate, immovable edges, von Karman, by Ritz with polynomials and harmonic balance
import numpy as np, itertools, sys
from scipy.optimize import fsolve
from scipy.linalg import eigh
nu=0.3; E=1.0; h=0.01; a=1.0; rho=1.0
M=int(sys.argv[1]) if len(sys.argv)>1 else 4; P=int(sys.argv[2]) if len(sys.argv)>2 else 6; K=int(sys.argv[3]) if len(sys.argv)>3 else 6
from numpy.polynomial import polynomial as Po, legendre as Le
g,wg=np.polynomial.legendre.leggauss(40)
s=2/a
def phi(m,sym=True): # even, clamped
    c=Po.polymul([1,0,-2,0,1], Le.leg2poly([0]*(2*m)+[1])); return c
def psi_odd(m): return Po.polymul([1,0,-1], Le.leg2poly([0]*(2*m+1)+[1]))
def psi_even(m): return Po.polymul([1,0,-1], Le.leg2poly([0]*(2*m)+[1]))
ev=lambda c,d: Po.polyval(g, Po.polyder(c,d) if d else c)*s**d
W=[[ev(phi(m),d) for d in range(3)] for m in range(M)]
Uo=[[ev(psi_odd(m),d) for d in range(2)] for m in range(P)]
Ue=[[ev(psi_even(m),d) for d in range(2)] for m in range(P)]
wt=np.outer(wg,wg)/s**2
ww=[(m,n) for m in range(M) for n in range(M)]
w=np.array([np.outer(W[m][0],W[n][0]) for m,n in ww]); wx=np.array([np.outer(W[m][1],W[n][0]) for m,n in ww]); wy=np.array([np.outer(W[m][0],W[n][1]) for m,n in ww])
wxx=np.array([np.outer(W[m][2],W[n][0]) for m,n in ww]); wyy=np.array([np.outer(W[m][0],W[n][2]) for m,n in ww]); wxy=np.array([np.outer(W[m][1],W[n][1]) for m,n in ww])
D=E*h**3/12/(1-nu**2); C=E*h/(1-nu**2)
I=lambda f,g_: np.einsum('axy,bxy,xy->ab',f,g_,wt,optimize=True)
Kb=D*(I(wxx,wxx)+I(wyy,wyy)+nu*(I(wxx,wyy)+I(wyy,wxx))+2*(1-nu)*I(wxy,wxy)); Mm=rho*h*I(w,w)
lam,V=eigh(Kb,Mm); V=V[:,:K]; om=np.sqrt(lam[:K])
uu=[(m,n) for m in range(P) for n in range(P)]
z=np.zeros_like
ux=np.array([np.outer(Uo[m][1],Ue[n][0]) for m,n in uu]); uy=np.array([np.outer(Uo[m][0],Ue[n][1]) for m,n in uu])
vx=np.array([np.outer(Ue[m][1],Uo[n][0]) for m,n in uu]); vy=np.array([np.outer(Ue[m][0],Uo[n][1]) for m,n in uu])
Z=np.zeros_like(ux)
ex=np.concatenate([ux,Z]); ey=np.concatenate([Z,vy]); gxy=np.concatenate([uy,vx])
Ku=C*(I(ex,ex)+I(ey,ey)+nu*(I(ex,ey)+I(ey,ex))+(1-nu)/2*I(gxy,gxy))
X=np.einsum('axy,ak->kxy',wx,V); Y=np.einsum('axy,ak->kxy',wy,V)
pairs=[(i,j) for i in range(K) for j in range(K)]
qx=np.array([0.5*X[i]*X[j] for i,j in pairs]); qy=np.array([0.5*Y[i]*Y[j] for i,j in pairs]); qg=np.array([0.5*(X[i]*Y[j]+Y[i]*X[j]) for i,j in pairs])
B=C*(I(ex,qx)+I(ey,qy)+nu*(I(ex,qy)+I(ey,qx))+(1-nu)/2*I(gxy,qg))
Q=C*(I(qx,qx)+I(qy,qy)+nu*(I(qx,qy)+I(qy,qx))+(1-nu)/2*I(qg,qg))
G=(Q-B.T@np.linalg.solve(Ku,B)).reshape(K,K,K,K)   # U = 1/2 G qqqq
T=sum(np.transpose(G,p) for p in itertools.permutations(range(4)))/24
force=lambda q: om**2*q+2*np.einsum('ijkl,j,k,l->i',T,q,q,q,optimize=True)
centre=np.array([Po.polyval(0.0,phi(m))*Po.polyval(0.0,phi(n)) for m,n in ww])@V
H=[1,3,5]; N=24; t=2*np.pi*np.arange(N)/N; Cs=np.array([np.cos(k*t) for k in H])
def res(x,amp):
    A=x[:-1].reshape(len(H),K); Om=x[-1]*om[0]
    q=Cs.T@A; R=np.array([force(v) for v in q])
    out=2/N*Cs@R-np.array([(k*Om)**2*A[i] for i,k in enumerate(H)])
    return np.append((out/om**2).ravel()/h, (A.sum(0)@centre-amp)/h)
x=np.zeros(len(H)*K+1); x[-1]=1.001; x[0]=0.01*h/centre[0]
print("omega lambda a^2 sqrt(rho h/D)", om[0]*a**2*np.sqrt(rho*h/D))
for r in np.arange(0.02,1.01,0.02):
    x=fsolve(res,x,args=(r*h,),xtol=1e-11)
    if any(abs(r-v)<1e-9 for v in (0.2,0.4,0.6,0.8,1.0)): print("w/h %.1f ratio %.5f"%(r,x[-1]), "res",abs(res(x,r*h)).max())
